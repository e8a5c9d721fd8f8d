#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include <chasles/frontend/equalise.hpp>

namespace chasles {
namespace {

using Histogram = std::array<int, 256>;
using Table = std::array<std::uint8_t, 256>;

constexpr int kTiles = 8;  // in each direction
constexpr double kMostSlope = 3;

// To the nearest integer, of two the even one; for 0 to 255 and a little more.
std::uint8_t rounded(float value) {
  const float shifted = value + 8388608.0f;  // 2^23: no place is left after the point
  std::uint32_t bits;
  std::memcpy(&bits, &shifted, sizeof bits);
  return static_cast<std::uint8_t>(std::min(bits & 0x7fffffu, 255u));
}

// The shares of the grey levels up to each one.
Table table_of(const Histogram& histogram, float scale) {
  Table table;
  int sum = 0;
  for (std::size_t v = 0; v < table.size(); ++v) {
    sum += histogram[v];
    table[v] = rounded(static_cast<float>(sum) * scale);
  }
  return table;
}

// Cuts peaks off and spreads what is cut evenly.
void limit(Histogram& histogram, int most) {
  int cut = 0;
  for (int& count : histogram) {
    cut += std::max(0, count - most);
    count = std::min(count, most);
  }
  const int each = cut / 256, rest = cut % 256;
  for (int& count : histogram) count += each;
  const int step = rest > 0 ? std::max(256 / rest, 1) : 256;
  for (int v = 0, left = rest; v < 256 && left > 0; v += step, --left) {
    ++histogram[static_cast<std::size_t>(v)];
  }
}

// The tiles of an image, which cover a little more than it where 8 does not divide its size.
struct Tiles {
  const GrayImage& image;
  int width, height;  // of a tile

  explicit Tiles(const GrayImage& of)
      : image(of), width(of.width / kTiles), height(of.height / kTiles) {
    if (of.width % kTiles != 0 || of.height % kTiles != 0) {
      ++width;
      ++height;
    }
  }
  // Mirrored beyond the edges.
  std::uint8_t at(int x, int y) const {
    const int u = x < image.width ? x : 2 * (image.width - 1) - x;
    const int v = y < image.height ? y : 2 * (image.height - 1) - y;
    return image.pixels[static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) +
                        static_cast<std::size_t>(u)];
  }
  Table table(int column, int row) const {
    Histogram histogram{};
    for (int y = row * height; y < (row + 1) * height; ++y) {
      for (int x = column * width; x < (column + 1) * width; ++x) ++histogram[at(x, y)];
    }
    const int pixels = width * height;
    limit(histogram, std::max(1, static_cast<int>(kMostSlope * pixels / 256)));
    return table_of(histogram, 255.0f / static_cast<float>(pixels));
  }
};

// The tiles before and after a pixel in one direction, and its share of the second.
struct Between {
  int before, after;
  float share;

  Between(int pixel, float per_tile) {
    const float place = static_cast<float>(pixel) * per_tile - 0.5f;
    const float whole = std::floor(place);
    share = place - whole;
    before = std::max(static_cast<int>(whole), 0);
    after = std::min(static_cast<int>(whole) + 1, kTiles - 1);
  }
};

}  // namespace

void equalise_histogram(const GrayImage& image, std::uint8_t* out, std::ptrdiff_t stride) {
  Histogram histogram{};
  for (const std::uint8_t pixel : image.pixels) ++histogram[pixel];
  const auto total = static_cast<int>(image.pixels.size());
  const auto darkest =
      std::find_if(histogram.begin(), histogram.end(), [](int n) { return n > 0; });
  Table table;
  if (*darkest == total) {
    table.fill(static_cast<std::uint8_t>(darkest - histogram.begin()));
  } else {
    const float scale = 255.0f / static_cast<float>(total - *darkest);
    *darkest = 0;
    table = table_of(histogram, scale);
  }
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* row = image.pixels.data() + std::ptrdiff_t{y} * image.width;
    std::transform(row, row + image.width, out + y * stride,
                   [&](std::uint8_t pixel) { return table[pixel]; });
  }
}

void equalise_tiles(const GrayImage& image, std::uint8_t* out, std::ptrdiff_t stride) {
  const Tiles tiles(image);
  std::array<std::array<Table, kTiles>, kTiles> tables;
  for (int row = 0; row < kTiles; ++row) {
    for (int column = 0; column < kTiles; ++column) {
      tables[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] =
          tiles.table(column, row);
    }
  }
  std::vector<Between> columns;
  for (int x = 0; x < image.width; ++x) {
    columns.emplace_back(x, 1.0f / static_cast<float>(tiles.width));
  }
  for (int y = 0; y < image.height; ++y) {
    const Between rows(y, 1.0f / static_cast<float>(tiles.height));
    const std::uint8_t* const row = image.pixels.data() + std::ptrdiff_t{y} * image.width;
    const auto& above = tables[static_cast<std::size_t>(rows.before)];
    const auto& below = tables[static_cast<std::size_t>(rows.after)];
    for (int x = 0; x < image.width; ++x) {
      const std::uint8_t value = row[x];
      const Between& b = columns[static_cast<std::size_t>(x)];
      const auto left = static_cast<std::size_t>(b.before),
                 right = static_cast<std::size_t>(b.after);
      const auto mix = [&](const std::array<Table, kTiles>& of) {
        return static_cast<float>(of[left][value]) * (1.0f - b.share) +
               static_cast<float>(of[right][value]) * b.share;
      };
      out[y * stride + x] = rounded(mix(above) * (1.0f - rows.share) + mix(below) * rows.share);
    }
  }
}

}  // namespace chasles
