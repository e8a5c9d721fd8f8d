#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/frontend/frontend_settings.hpp>
#include <chasles/frontend/image_pyramid.hpp>

namespace chasles {

/// A rectangle of pixels: x0 <= x < x1, y0 <= y < y1.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  bool empty() const { return x1 <= x0 || y1 <= y0; }
};

/// A pixel where the image has texture in two directions.
struct Corner {
  Eigen::Vector2d pixel;  ///< [px]
  float score = 0;        ///< value of the measure; comparable within one image only
};

/// The corners in a box of the image: local maxima (3 x 3 pixels) of the measure over windows of 7
/// x 7 pixels. The rms gradient in the weakest direction is at least min_gradient [grey levels/px].
/// Best first; corners of equal score from top to bottom, left to right.
std::vector<Corner> find_corners(const PyramidLevel& image, const PixelBox& box,
                                 CornerMeasure measure, double min_gradient);

/// The sub-pixel position of a corner [px] (Förstner: the point nearest to the lines across the
/// gradients around it). Returns the given position if this does not converge within 4 pixels (half
/// the window).
Eigen::Vector2d refine_corner(const PyramidLevel& image, const Eigen::Vector2d& pixel);

}  // namespace chasles
