#pragma once

#include <array>
#include <map>
#include <vector>

#include <Eigen/Core>

#include <chasles/target/saddle_points.hpp>

namespace chasles {

/// Four saddle points with straight edges between them, dark on one side and light on the other: a
/// square of a board, black or white. Clockwise as seen in the image.
struct Quad {
  std::array<int, 4> corners = {};  ///< indices of saddle points
  bool dark = false;                ///< inside
};

/// The quads between saddle points.
std::vector<Quad> find_quads(const GreyPlane& image, const std::vector<SaddlePoint>& points);

/// A part of a board: quads that share edges, and where their corners are in its grid.
struct CornerLattice {
  std::vector<int> quads;                    ///< indices
  std::map<int, Eigen::Vector2i> positions;  ///< of saddle points; from x to y clockwise, one apart
};

/// Whether a straight edge leads from one saddle point to the other, along a direction of each,
/// dark on one side and light on the other all the way.
bool is_connected(const GreyPlane& image, const SaddlePoint& from, const SaddlePoint& to);

/// The connected parts, the one with the most quads first. A quad that contradicts earlier ones
/// stays out.
std::vector<CornerLattice> connect_quads(const std::vector<Quad>& quads);

}  // namespace chasles
