#pragma once

#include <string>

#include <chasles/camera/image_frame.hpp>

namespace chasles {

/// A JPEG of the image for display, at most `most_width` [px] wide. Wider images are reduced by
/// averaging. The same image gives the same bytes. Empty for an empty image.
std::string jpeg_bytes(const GrayImage& image, int most_width);

/// A PNG of the image, which is not empty; made quickly rather than small.
std::string png_bytes(const GrayImage& image);

}  // namespace chasles
