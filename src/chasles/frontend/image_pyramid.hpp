#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <chasles/camera/image_frame.hpp>
#include <chasles/frontend/frontend_settings.hpp>

namespace chasles {

/// One level of a pyramid: an image with kPad mirrored pixels added on each side, so that a patch
/// around any point of the image can be read without bounds checks.
struct PyramidLevel {
  static constexpr int kPad = 24;  ///< [px]
  int width = 0, height = 0;       ///< without padding [px]
  std::vector<std::uint8_t> padded;

  int stride() const { return width + 2 * kPad; }
  /// The pixel (x, y), -kPad <= x < width + kPad, likewise y; the rest of the row follows it.
  const std::uint8_t* at(int x, int y) const {
    return padded.data() + static_cast<std::ptrdiff_t>(y + kPad) * stride() + x + kPad;
  }
};

/// An image and its reductions by factors of two: pixel (x, y) of level 0 is (x/2, y/2) of level 1.
struct ImagePyramid {
  std::vector<PyramidLevel> levels;

  bool empty() const { return levels.empty(); }
};

/// Builds the pyramid of `image` in `pyramid`, whose memory is reused. It has `levels` levels, or
/// fewer if a level would be smaller than kPad + 1 on a side. Throws InputError if the image does
/// not have width x height pixels, or is too small.
void build_pyramid(const GrayImage& image, Equalisation equalisation, int levels,
                   ImagePyramid& pyramid);

/// Whether the grey levels of an image are usable.
enum class Exposure { kUsable, kBlack, kSaturated };

/// Black or saturated: at least 98 % of the pixels of the coarsest level are below 8 or above 247.
Exposure exposure(const ImagePyramid& pyramid);

}  // namespace chasles
