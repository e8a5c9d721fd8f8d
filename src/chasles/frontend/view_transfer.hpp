#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

/// Where a pixel of one view lies in another one, and how its surroundings are bent there.
struct Transfer {
  Eigen::Vector2d pixel;            ///< in the other view, perhaps outside its image [px]
  Eigen::Matrix2d to_A_from;        ///< d pixel / d pixel of the first view
  Eigen::Vector2d d_inverse_depth;  ///< d pixel / d inverse depth [px m]
};

/// The point on the ray (x/z, y/z, 1) of one camera with this inverse depth 1/z [1/m] (0: at
/// infinity), as seen by the camera `to`; none where that cannot see it. For neighbouring pixels
/// the depth counts as equal.
std::optional<Transfer> transfer(const PixelRay& from, double inverse_depth, const SE3& to_T_from,
                                 const Camera& to);

}  // namespace chasles
