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

/// Throws UsageError if the lens model has no ray in front of the camera for a pixel.
RayTable make_rays(const Camera& camera);

/// Rays in the axes of a face (camera/anchor_face.hpp), of all pixels of the image; those of the
/// pixels that are not listed have no meaning, but are finite.
struct RayFace {
  Eigen::Matrix3d cam_R_face = Eigen::Matrix3d::Identity();
  RayTable rays;
  std::vector<std::size_t> pixels;  ///< those of this face
};

/// The rays of all pixels: in one face where each is less than 90 degrees off the axis, else in
/// those of their directions. A pixel outside the circle of a lens that sees 90 degrees there has
/// no face. Throws UsageError where the lens model folds over before.
std::vector<RayFace> make_faces(const Camera& camera);

/// Some lines of an image, rows or columns: [first, last).
struct Lines {
  int first = 0, last = 0;
  bool are_rows = true;
};

/// The rays of these lines, those of line first + i rotated by `rotations[i]`.
RayTable rotated_lines(const RayTable& rays, const Lines& lines,
                       const std::vector<Eigen::Matrix3f>& rotations);

}  // namespace chasles
