#pragma once

#include <string>

#include <chasles/camera/image_frame.hpp>

namespace chasles {

/// A JPEG of the image, for people to look at: no wider than `most_width` [px], made smaller by
/// averaging where it is. The same image gives the same bytes. Nothing for an empty image.
std::string jpeg_bytes(const GrayImage& image, int most_width);

}  // namespace chasles
