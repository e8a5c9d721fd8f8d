#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace chasles {

/// A picture of a surface in shades of grey; (0, 0) is the upper left corner.
struct Canvas {
  int width = 0, height = 0;         ///< [texels]
  double texel = 0;                  ///< edge of a texel [m]
  std::vector<std::uint8_t> pixels;  ///< height x width

  double width_m() const { return width * texel; }
  double height_m() const { return height * texel; }
};

/// One level of a texture: texels of 2^level of the canvas, with a repeated border of one texel on
/// every side, so that interpolation needs no bounds checks.
struct MipLevel {
  int width = 0, height = 0;         ///< without the border
  std::size_t stride = 0;            ///< from row to row, border included
  std::vector<std::uint8_t> pixels;  ///< (height + 2) x stride
};

/// A picture at all scales; each level is the mean of 2 x 2 texels of the one before.
struct Texture {
  std::vector<MipLevel> levels;
};

Texture make_texture(const Canvas& canvas);

/// 2^16 times the shade, bilinear between texel centres at (i + 1/2, j + 1/2), with weights in
/// steps of 1/256; u in [0, width], v in [0, height].
inline int sample_level(const MipLevel& level, float u, float v) {
  const auto x = static_cast<int>(u * 256 + 128), y = static_cast<int>(v * 256 + 128);
  const int a = x & 255, b = y & 255;
  const std::uint8_t* p = level.pixels.data() + static_cast<std::size_t>(y >> 8) * level.stride +
                          static_cast<std::size_t>(x >> 8);
  const std::uint8_t* q = p + level.stride;
  return (p[0] * (256 - a) + p[1] * a) * (256 - b) + (q[0] * (256 - a) + q[1] * a) * b;
}

/// Trilinear sample: u in [0, width], v in [0, height] of the finest level, `lod` the binary
/// logarithm of the sample's extent in its texels. Below 0 the finest level is magnified.
inline float sample(const Texture& texture, float u, float v, float lod) {
  constexpr float kShade = 0x1p-16F;
  const auto coarsest = static_cast<int>(texture.levels.size()) - 1;
  if (lod <= 0 || coarsest == 0)
    return kShade * static_cast<float>(sample_level(texture.levels.front(), u, v));
  const int below = lod < static_cast<float>(coarsest) ? static_cast<int>(lod) : coarsest - 1;
  const float part = lod < static_cast<float>(coarsest) ? lod - static_cast<float>(below) : 1;
  float scale = 1.0F / static_cast<float>(1 << below);
  const MipLevel* level = texture.levels.data() + below;
  const auto fine = static_cast<float>(sample_level(level[0], u * scale, v * scale));
  scale *= 0.5F;
  const auto coarse = static_cast<float>(sample_level(level[1], u * scale, v * scale));
  return kShade * (fine + part * (coarse - fine));
}

}  // namespace chasles
