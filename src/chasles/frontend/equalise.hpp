#pragma once

#include <cstddef>
#include <cstdint>

#include <chasles/camera/image_frame.hpp>

namespace chasles {

/// Writes the image with an equalised histogram: its grey levels become about equally frequent.
/// `out`: rows of the image's width, `stride` apart. The pixels are those of OpenCV's equalizeHist.
void equalise_histogram(const GrayImage& image, std::uint8_t* out, std::ptrdiff_t stride);

/// The same within each of 8 x 8 tiles, with slopes of at most 3, interpolated between the tiles
/// (contrast-limited adaptive histogram equalisation: Zuiderveld, Graphics Gems IV, 1994). The
/// pixels are those of OpenCV's CLAHE.
void equalise_tiles(const GrayImage& image, std::uint8_t* out, std::ptrdiff_t stride);

}  // namespace chasles
