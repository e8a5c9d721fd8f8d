#pragma once

#include <cstdint>
#include <vector>

#include <chasles/time.hpp>

namespace chasles {

/// An image in shades of grey: 8 bits a pixel, row after row, without gaps.
struct GrayImage {
  int width = 0, height = 0;         ///< [px]
  std::vector<std::uint8_t> pixels;  ///< height x width

  bool empty() const { return pixels.empty(); }
};

/// What the cameras of a rig saw at one instant: one image a camera, in the order of the rig; an
/// empty one where a camera has none.
struct ImageFrame {
  Time time{};
  std::vector<GrayImage> images;
};

}  // namespace chasles
