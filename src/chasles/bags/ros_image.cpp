#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <chasles/bags/bayer.hpp>
#include <chasles/bags/ros_image.hpp>
#include <chasles/base/error.hpp>
#include <chasles/codec/bytes.hpp>
#include <chasles/codec/image_kinds.hpp>
#include <chasles/codec/image_range.hpp>

namespace chasles {
namespace {

/// How the values of a pixel lie in the bytes.
struct PixelLayout {
  std::string_view name;
  int bytes = 1;      // of a value
  int values = 1;     // of a pixel
  int first = 0;      // the value that is grey or red
  int last = 0;       // the value that is grey or blue; green lies between them
  int red = -1;       // of a Bayer mosaic: the place of red, 2 * row + column
  bool half = false;  // below the rows of grey there are half as many of colours
};

// 8UC3 and its like say nothing of the order; OpenCV, whose names they are, has blue first.
constexpr std::array kLayouts{
    PixelLayout{.name = "mono8"},
    PixelLayout{.name = "8UC1"},
    PixelLayout{.name = "mono16", .bytes = 2},
    PixelLayout{.name = "16UC1", .bytes = 2},
    PixelLayout{.name = "rgb8", .values = 3, .first = 0, .last = 2},
    PixelLayout{.name = "bgr8", .values = 3, .first = 2, .last = 0},
    PixelLayout{.name = "8UC3", .values = 3, .first = 2, .last = 0},
    PixelLayout{.name = "rgba8", .values = 4, .first = 0, .last = 2},
    PixelLayout{.name = "bgra8", .values = 4, .first = 2, .last = 0},
    PixelLayout{.name = "8UC4", .values = 4, .first = 2, .last = 0},
    PixelLayout{.name = "rgb16", .bytes = 2, .values = 3, .first = 0, .last = 2},
    PixelLayout{.name = "bgr16", .bytes = 2, .values = 3, .first = 2, .last = 0},
    PixelLayout{.name = "16UC3", .bytes = 2, .values = 3, .first = 2, .last = 0},
    PixelLayout{.name = "rgba16", .bytes = 2, .values = 4, .first = 0, .last = 2},
    PixelLayout{.name = "bgra16", .bytes = 2, .values = 4, .first = 2, .last = 0},
    PixelLayout{.name = "16UC4", .bytes = 2, .values = 4, .first = 2, .last = 0},
    PixelLayout{.name = "bayer_rggb8", .red = 0},
    PixelLayout{.name = "bayer_grbg8", .red = 1},
    PixelLayout{.name = "bayer_gbrg8", .red = 2},
    PixelLayout{.name = "bayer_bggr8", .red = 3},
    PixelLayout{.name = "bayer_rggb16", .bytes = 2, .red = 0},
    PixelLayout{.name = "bayer_grbg16", .bytes = 2, .red = 1},
    PixelLayout{.name = "bayer_gbrg16", .bytes = 2, .red = 2},
    PixelLayout{.name = "bayer_bggr16", .bytes = 2, .red = 3},
    PixelLayout{.name = "yuv422", .values = 2, .first = 1, .last = 1},
    PixelLayout{.name = "uyvy", .values = 2, .first = 1, .last = 1},
    PixelLayout{.name = "yuv422_yuy2", .values = 2, .first = 0, .last = 0},
    PixelLayout{.name = "yuyv", .values = 2, .first = 0, .last = 0},
    PixelLayout{.name = "nv12", .half = true},
    PixelLayout{.name = "nv21", .half = true},
};

const PixelLayout& layout_of(std::string_view encoding, const std::string& where) {
  std::string known;
  for (const PixelLayout& layout : kLayouts) {
    if (layout.name == encoding) return layout;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", layout.name);
  }
  throw InputError(
      fmt::format("{}: the encoding is '{:.30}', expected one of {}", where, encoding, known));
}

/// The layout of an image of the expected size whose rows lie within its data.
const PixelLayout& checked_layout(const RosImage& image, const ImageSize& expected,
                                  const std::string& where) {
  if (std::cmp_not_equal(image.width, expected.width) ||
      std::cmp_not_equal(image.height, expected.height)) {
    throw InputError(fmt::format("{}: is {} x {} pixels, expected {} x {} as in the calibration",
                                 where, image.width, image.height, expected.width,
                                 expected.height));
  }
  if (image.width == 0 || image.height == 0) throw InputError(where + ": has no pixels");
  const PixelLayout& layout = layout_of(image.encoding, where);
  const std::size_t row = std::size_t{image.width} * static_cast<std::size_t>(layout.bytes) *
                          static_cast<std::size_t>(layout.values);
  const std::size_t rows = image.height + (layout.half ? (std::size_t{image.height} + 1) / 2 : 0);
  if (image.step >= row && image.data.size() / rows >= image.step) return layout;
  throw InputError(fmt::format("{}: holds {} bytes in rows of {}, expected {} rows of {} or more",
                               where, image.data.size(), image.step, rows, row));
}

/// Value `i` of a row, of one byte or two.
std::uint32_t value_at(std::string_view row, std::size_t i, int bytes, bool big_endian) {
  if (bytes == 1) return byte_at(row, i);
  const std::uint32_t first = byte_at(row, 2 * i), second = byte_at(row, 2 * i + 1);
  return big_endian ? first << 8 | second : second << 8 | first;
}

template <typename Visit>
void for_each_row(const RosImage& image, Visit&& visit) {
  for (std::size_t v = 0; v < image.height; ++v) visit(image.data.substr(v * image.step));
}

std::vector<std::uint16_t> values_of(const RosImage& image, const PixelLayout& layout) {
  std::vector<std::uint16_t> values;
  values.reserve(std::size_t{image.width} * image.height);
  const auto count = static_cast<std::size_t>(layout.values);
  const auto first = static_cast<std::size_t>(layout.first);
  const auto last = static_cast<std::size_t>(layout.last);
  for_each_row(image, [&](std::string_view row) {
    for (std::size_t u = 0; u < image.width * count; u += count) {
      const auto at = [&](std::size_t i) {
        return value_at(row, u + i, layout.bytes, image.big_endian);
      };
      values.push_back(static_cast<std::uint16_t>(
          first == last ? at(first) : grey_of_colour(at(first), at(1), at(last))));
    }
  });
  return values;
}

}  // namespace

void check_encoding(std::string_view encoding, const std::string& where) {
  layout_of(encoding, where);
}

std::optional<int> largest_deep_value(const RosImage& image, const ImageSize& expected,
                                      const std::string& where) {
  const PixelLayout& layout = checked_layout(image, expected, where);
  if (layout.bytes == 1) return std::nullopt;
  return largest_but_hot(values_of(image, layout));
}

GrayImage grey_image(const RosImage& image, const ImageSize& expected, int bits,
                     const std::string& where) {
  const PixelLayout& layout = checked_layout(image, expected, where);
  std::vector<std::uint16_t> values = values_of(image, layout);
  if (layout.red >= 0) {
    values = grey_of_mosaic(values, expected.width, expected.height, layout.red);
  }
  GrayImage grey{.width = expected.width, .height = expected.height, .pixels = {}};
  grey.pixels.reserve(values.size());
  const int by = layout.bytes == 1 ? 0 : bits - 8;
  for (const std::uint16_t value : values) {
    grey.pixels.push_back(static_cast<std::uint8_t>(std::min(value >> by, 255)));
  }
  return grey;
}

}  // namespace chasles
