#pragma once

#include <cstdint>
#include <vector>

#include <chasles/base/time.hpp>

namespace chasles {

/// A grey image: 8 bits per pixel, row by row, without gaps.
struct GrayImage {
  int width = 0, height = 0;         ///< [px]
  std::vector<std::uint8_t> pixels;  ///< height x width

  bool empty() const { return pixels.empty(); }
};

/// The images of a rig at one instant: one per camera, in the order of the rig. An image is empty
/// if its camera has none.
struct ImageFrame {
  Time time{};
  std::vector<GrayImage> images;
};

}  // namespace chasles
