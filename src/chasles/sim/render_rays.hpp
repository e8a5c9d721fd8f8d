#pragma once

#include <vector>

#include <chasles/camera/camera.hpp>

namespace chasles {

/// The bounds of the rays (x, y, 1) of some pixels, half a pixel beyond their centres.
struct RayBounds {
  float x_min, x_max, y_min, y_max;
};

/// Pixels [left, right) x [top, bottom) and their rays.
struct RayBlock {
  int left, top, right, bottom;
  RayBounds bounds;
  float x_u, x_v, y_u, y_v;  ///< d (x, y) / d pixel at the centre [1/px]
};

/// The rays (x, y, 1) of a camera's pixels, in the camera's frame, row by row.
struct RayTable {
  int width = 0, height = 0;
  std::vector<float> x, y;
  /// All pixels in tiles of 64 x 64, those in blocks of 8 x 8, those in quarters of 4 x 4; each
  /// list row by row.
  std::vector<RayBlock> tiles, blocks, quarters;

  std::size_t at(int u, int v) const { return static_cast<std::size_t>(v * width + u); }
};

inline constexpr int kTileEdge = 64, kBlockEdge = 8, kQuarterEdge = 4;  ///< [px]

/// Throws UsageError if the lens model has no ray for a pixel.
RayTable make_rays(const Camera& camera);

/// Some lines of an image, rows or columns: [first, last).
struct Lines {
  int first = 0, last = 0;
  bool are_rows = true;
};

/// The rays of these lines, those of line first + i rotated by `rotations[i]`.
RayTable rotated_lines(const RayTable& rays, const Lines& lines,
                       const std::vector<Eigen::Matrix3f>& rotations);

}  // namespace chasles
