#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/image_frame.hpp>

namespace chasles {

/// A grey image of single-precision numbers, row by row.
struct GreyPlane {
  int width = 0, height = 0;
  std::vector<float> values;

  const float* row(int y) const { return values.data() + static_cast<std::size_t>(y) * width; }
  float* row(int y) { return values.data() + static_cast<std::size_t>(y) * width; }
  /// The value between pixels; the pixel must lie within the image.
  float at(const Eigen::Vector2d& pixel) const;
  bool contains(const Eigen::Vector2d& pixel, double border) const;
};

/// The image smoothed by (1 4 6 4 1)/16 in both directions: a standard deviation of one pixel. At
/// the edge of the image its last pixels repeat.
GreyPlane smoothed(const GreyPlane& image);

/// The grey values of an image.
GreyPlane grey_plane(const GrayImage& image);

/// A point where two straight edges cross, black and white in turn: a corner of a checkerboard, or
/// where squares touch.
struct SaddlePoint {
  Eigen::Vector2d pixel;
  /// Directions of the four edges from the point, rising by less than a full turn; angles from the
  /// image's x towards its y axis [rad]. It is dark from the first to the second and from the third
  /// to the fourth.
  std::array<double, 4> edges = {};
  double dark = 0, light = 0;  ///< grey values beside the edges
  double blur = 0;             ///< standard deviation of the edges' blur [px]
};

/// The saddle points of an image, those of sharp and of blurred edges. The position is good to
/// about 0.3 px. Squares must have sides of five pixels or more.
std::vector<SaddlePoint> find_saddle_points(const GreyPlane& image);

}  // namespace chasles
