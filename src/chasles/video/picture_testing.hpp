#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <chasles/video/video_testing.hpp>

// Pictures for the tests of videos.
namespace chasles::test {

/// A textured picture that moves: all greys, the number of the picture in its corner.
inline GrayImage moving_picture(int number, int width = 64, int height = 48) {
  GrayImage image{.width = width, .height = height, .pixels = {}};
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const int grey = 4 * (u + 3 * number) + 5 * v + ((u / 5 + v / 3) % 2) * 30;
      image.pixels.push_back(static_cast<std::uint8_t>(grey % 256));
    }
  }
  for (int v = 0; v < 8; ++v) {
    for (int u = 0; u < 8; ++u) {
      image.pixels[static_cast<std::size_t>(v * width + u)] =
          static_cast<std::uint8_t>(20 + 7 * number);
    }
  }
  return image;
}

/// `count` of them, at uneven times: 33, 34, 50 ms apart in turn.
inline std::vector<ImageFrame> moving_pictures(int count, int width = 64, int height = 48) {
  std::vector<ImageFrame> pictures;
  Time time{};
  for (int i = 0; i < count; ++i) {
    pictures.push_back({.time = time, .images = {moving_picture(i, width, height)}});
    time += std::chrono::milliseconds(i % 3 == 0 ? 33 : i % 3 == 1 ? 34 : 50);
  }
  return pictures;
}

}  // namespace chasles::test
