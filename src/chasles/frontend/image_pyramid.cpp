#include <algorithm>
#include <string>
#include <vector>

#include <chasles/base/error.hpp>
#include <chasles/base/vector_clones.hpp>
#include <chasles/frontend/equalise.hpp>
#include <chasles/frontend/image_pyramid.hpp>

namespace chasles {
namespace {

constexpr int kPad = PyramidLevel::kPad;

void resize(PyramidLevel& level, int width, int height) {
  level.width = width;
  level.height = height;
  level.padded.resize(static_cast<std::size_t>(level.stride()) *
                      static_cast<std::size_t>(height + 2 * kPad));
}

std::uint8_t* row_of(PyramidLevel& level, int y) {
  return level.padded.data() + static_cast<std::ptrdiff_t>(y + kPad) * level.stride() + kPad;
}

// Mirrors the pixels beyond the edges, which are not repeated.
void pad(PyramidLevel& level) {
  for (int y = 0; y < level.height; ++y) {
    std::uint8_t* row = row_of(level, y);
    for (int i = 1; i <= kPad; ++i) {
      row[-i] = row[i];
      row[level.width - 1 + i] = row[level.width - 1 - i];
    }
  }
  const auto copy = [&](int from, int to) {
    std::copy_n(row_of(level, from) - kPad, level.stride(), row_of(level, to) - kPad);
  };
  for (int i = 1; i <= kPad; ++i) {
    copy(i, -i);
    copy(level.height - 1 - i, level.height - 1 + i);
  }
}

void copy_equalised(const GrayImage& image, Equalisation equalisation, PyramidLevel& level) {
  switch (equalisation) {
    case Equalisation::kNone:
      for (int y = 0; y < image.height; ++y) {
        std::copy_n(image.pixels.data() + std::ptrdiff_t{y} * image.width, image.width,
                    row_of(level, y));
      }
      return;
    case Equalisation::kHistogram:
      return equalise_histogram(image, row_of(level, 0), level.stride());
    case Equalisation::kClahe:
      return equalise_tiles(image, row_of(level, 0), level.stride());
  }
}

std::uint16_t weighted(int a, int b, int c, int d, int e) {
  return static_cast<std::uint16_t>(a + 4 * (b + d) + 6 * c + e);
}

// Sums of a row and its neighbours. The qualifiers exclude aliasing, so that the compiler
// vectorises the loops.
void sum_down(const std::uint8_t* __restrict row, std::ptrdiff_t down, std::size_t columns,
              std::uint16_t* __restrict sums) {
  const std::uint8_t *above = row - down, *below = row + down;
  for (std::size_t x = 0; x < columns; ++x) {
    sums[x] = weighted(above[static_cast<std::ptrdiff_t>(x) - down], above[x], row[x], below[x],
                       below[static_cast<std::ptrdiff_t>(x) + down]);
  }
}

// Every second sum of a row of sums, rounded.
void sum_along(const std::uint16_t* __restrict sums, std::size_t columns,
               std::uint8_t* __restrict out) {
  for (std::size_t x = 0; x < columns; ++x) {
    const std::uint16_t* s = sums + 2 * x;
    const std::uint16_t sum = weighted(s[0], s[1], s[2], s[3], s[4]);
    out[x] = static_cast<std::uint8_t>(static_cast<std::uint16_t>(sum + 128) >> 8);
  }
}

// The weights (1 4 6 4 1) / 16 in both directions, at every second pixel (Burt and Adelson, 1983),
// rounded: in integers of 16 bits, of which the largest sum leaves 127. At the edges it reads the
// padding.
CHASLES_VECTOR_CLONES
void halve(const PyramidLevel& fine, PyramidLevel& coarse, std::vector<std::uint16_t>& sums) {
  const auto width = static_cast<std::size_t>(coarse.width);
  const std::size_t columns = 2 * width + 3;
  sums.resize(columns);
  for (int y = 0; y < coarse.height; ++y) {
    sum_down(fine.at(-2, 2 * y), fine.stride(), columns, sums.data());
    sum_along(sums.data(), width, row_of(coarse, y));
  }
}

void require_size(const GrayImage& image) {
  const bool positive = image.width > kPad && image.height > kPad;
  if (positive && image.pixels.size() == static_cast<std::size_t>(image.width) *
                                             static_cast<std::size_t>(image.height)) {
    return;
  }
  throw InputError("image: found " + std::to_string(image.pixels.size()) + " pixels for " +
                   std::to_string(image.width) + " x " + std::to_string(image.height) +
                   ", expected width x height, each above " + std::to_string(kPad));
}

}  // namespace

void build_pyramid(const GrayImage& image, Equalisation equalisation, int levels,
                   ImagePyramid& pyramid) {
  require_size(image);
  const int smallest = std::min(image.width, image.height);
  int count = 1;
  while (count < levels && (smallest >> count) > kPad) ++count;
  pyramid.levels.resize(static_cast<std::size_t>(count));
  std::vector<std::uint16_t> sums;
  for (std::size_t l = 0; l < pyramid.levels.size(); ++l) {
    PyramidLevel& level = pyramid.levels[l];
    if (l == 0) {
      resize(level, image.width, image.height);
      copy_equalised(image, equalisation, level);
    } else {
      const PyramidLevel& finer = pyramid.levels[l - 1];
      resize(level, (finer.width + 1) / 2, (finer.height + 1) / 2);
      halve(finer, level, sums);
    }
    pad(level);
  }
}

Exposure exposure(const ImagePyramid& pyramid) {
  const PyramidLevel& level = pyramid.levels.back();
  const int pixels = level.width * level.height;
  int black = 0, white = 0;
  for (int y = 0; y < level.height; ++y) {
    const std::uint8_t* row = level.at(0, y);
    black += static_cast<int>(std::count_if(row, row + level.width, [](int v) { return v < 8; }));
    white += static_cast<int>(std::count_if(row, row + level.width, [](int v) { return v > 247; }));
  }
  if (black * 50 >= pixels * 49) return Exposure::kBlack;
  if (white * 50 >= pixels * 49) return Exposure::kSaturated;
  return Exposure::kUsable;
}

}  // namespace chasles
