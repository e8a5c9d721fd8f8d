#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace chasles {

/// A point of a board and its pixel.
struct BoardPixel {
  Eigen::Vector2d on_board;  ///< [m]
  Eigen::Vector2d pixel;
};

/// The homography from the board to pixels that fits the points best: at least four, not on a line.
/// None where they do not determine it.
std::optional<Eigen::Matrix3d> local_homography(const std::vector<BoardPixel>& points);

}  // namespace chasles
