#include <algorithm>

#include <chasles/sim/texture.hpp>

namespace chasles {
namespace {

MipLevel blank(int width, int height) {
  const std::size_t stride = static_cast<std::size_t>(width) + 2;
  return {.width = width,
          .height = height,
          .stride = stride,
          .pixels = std::vector<std::uint8_t>(stride * (static_cast<std::size_t>(height) + 2))};
}

std::uint8_t* row(MipLevel& level, int y) {
  return level.pixels.data() + static_cast<std::size_t>(y + 1) * level.stride + 1;
}

const std::uint8_t* row(const MipLevel& level, int y) {
  return level.pixels.data() + static_cast<std::size_t>(y + 1) * level.stride + 1;
}

void fill_border(MipLevel& level) {
  for (int y = 0; y < level.height; ++y) {
    std::uint8_t* p = row(level, y);
    p[-1] = p[0];
    p[level.width] = p[level.width - 1];
  }
  const auto stride = static_cast<std::ptrdiff_t>(level.stride);
  std::copy_n(row(level, 0) - 1, stride, row(level, -1) - 1);
  std::copy_n(row(level, level.height - 1) - 1, stride, row(level, level.height) - 1);
}

// An odd edge is repeated, from the border of the finer level.
MipLevel halved(const MipLevel& fine) {
  MipLevel coarse = blank((fine.width + 1) / 2, (fine.height + 1) / 2);
  for (int y = 0; y < coarse.height; ++y) {
    const std::uint8_t *p = row(fine, 2 * y), *q = row(fine, 2 * y + 1);
    std::uint8_t* out = row(coarse, y);
    for (int x = 0; x < coarse.width; ++x) {
      out[x] =
          static_cast<std::uint8_t>((p[2 * x] + p[2 * x + 1] + q[2 * x] + q[2 * x + 1] + 2) / 4);
    }
  }
  fill_border(coarse);
  return coarse;
}

}  // namespace

Texture make_texture(const Canvas& canvas) {
  Texture texture;
  MipLevel first = blank(canvas.width, canvas.height);
  for (int y = 0; y < canvas.height; ++y) {
    std::copy_n(canvas.pixels.data() + static_cast<std::size_t>(y) * canvas.width, canvas.width,
                row(first, y));
  }
  fill_border(first);
  texture.levels.push_back(std::move(first));
  while (texture.levels.back().width > 1 || texture.levels.back().height > 1) {
    texture.levels.push_back(halved(texture.levels.back()));
  }
  return texture;
}

}  // namespace chasles
