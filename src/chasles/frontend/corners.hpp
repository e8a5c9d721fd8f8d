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
  float score = 0;        ///< its measure, to be compared within one image only
};

/// The corners in a box of the image: local maxima (3 x 3 pixels) of the measure over windows of 7
/// x 7, where the mean squared gradient in the weakest direction is at least min_gradient squared
/// [grey levels/px]. Best first; those of equal score from top to bottom, left to right.
std::vector<Corner> find_corners(const PyramidLevel& image, const PixelBox& box,
                                 CornerMeasure measure, double min_gradient);

/// The corner's place to a fraction of a pixel (Förstner's: where the gradients of its surroundings
/// point to); the given one where that does not converge within 4 pixels (half the window).
Eigen::Vector2d refine_corner(const PyramidLevel& image, const Eigen::Vector2d& pixel);

}  // namespace chasles
