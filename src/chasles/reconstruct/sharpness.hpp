#pragma once

#include <vector>

#include <chasles/camera/image_frame.hpp>

namespace chasles {

/// The variance of an image's Laplacian, at half of its resolution, where noise counts less. Blur
/// lowers it; so does a scene without texture, hence relative_sharpness().
double sharpness(const GrayImage& image);

/// Each value as a part of the median of the five before it and the five after it; 1 where that is
/// 0 or there are none.
std::vector<double> relative_sharpness(const std::vector<double>& values);

}  // namespace chasles
