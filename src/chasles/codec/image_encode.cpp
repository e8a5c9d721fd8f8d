#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <vector>

#include <chasles/codec/image_encode.hpp>
#include <chasles/codec/jpeg_error.hpp>

namespace chasles {
namespace {

constexpr int kQuality = 50;

// How a pixel is shared between the part of the smaller image that it begins in, and the next one.
struct Shares {
  std::size_t part;
  std::uint64_t here, next;  // in units of 1 / number of parts
};

// Of `from` pixels on `to` parts, to <= from.
std::vector<Shares> shares_of(int from, int to) {
  std::vector<Shares> shares;
  for (std::int64_t n = 0; n < from; ++n) {
    const std::int64_t begin = n * to, part = begin / from, edge = (part + 1) * from;
    const std::int64_t here = std::min<std::int64_t>(to, edge - begin);
    shares.push_back({.part = static_cast<std::size_t>(part),
                      .here = static_cast<std::uint64_t>(here),
                      .next = static_cast<std::uint64_t>(to - here)});
  }
  return shares;
}

// Each pixel is the mean over its part of the image, in integers.
GrayImage reduced(const GrayImage& image, int width, int height) {
  const std::vector<Shares> columns = shares_of(image.width, width),
                            rows = shares_of(image.height, height);
  const auto stride = static_cast<std::size_t>(width);
  std::vector<std::uint64_t> sums(stride * static_cast<std::size_t>(height + 1)),
      of_row(stride + 1);
  const std::uint8_t* pixel = image.pixels.data();
  for (const Shares& row : rows) {
    std::fill(of_row.begin(), of_row.end(), 0);
    for (const Shares& column : columns) {
      of_row[column.part] += column.here * *pixel;
      of_row[column.part + 1] += column.next * *pixel++;
    }
    std::uint64_t* const sum = sums.data() + row.part * stride;
    for (std::size_t u = 0; u < stride; ++u) {
      sum[u] += row.here * of_row[u];
      sum[u + stride] += row.next * of_row[u];
    }
  }
  const std::uint64_t all = columns.size() * rows.size();
  GrayImage small{.width = width, .height = height, .pixels = {}};
  for (std::size_t i = 0; i < stride * static_cast<std::size_t>(height); ++i) {
    small.pixels.push_back(static_cast<std::uint8_t>((sums[i] + all / 2) / all));
  }
  return small;
}

// Plain C: libjpeg jumps out of it at an error. Returns whether all was written.
bool compress(const GrayImage& image, jpeg_compress_struct& jpeg, JpegErrors& errors,
              unsigned char** bytes, unsigned long* size) {
  if (setjmp(errors.jump) != 0) return false;
  jpeg_create_compress(&jpeg);
  jpeg_mem_dest(&jpeg, bytes, size);
  jpeg.image_width = static_cast<JDIMENSION>(image.width);
  jpeg.image_height = static_cast<JDIMENSION>(image.height);
  jpeg.input_components = 1;
  jpeg.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, kQuality, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  while (jpeg.next_scanline < jpeg.image_height) {
    // libjpeg's rows are not const; it only reads them.
    JSAMPROW row = const_cast<JSAMPROW>(image.pixels.data() +
                                        std::size_t{jpeg.next_scanline} * jpeg.image_width);
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  return true;
}

}  // namespace

std::string jpeg_bytes(const GrayImage& image, int most_width) {
  if (image.empty()) return {};
  if (image.width > most_width) {
    const double scale = static_cast<double>(most_width) / image.width;
    const int height = std::max(1, static_cast<int>(std::lround(scale * image.height)));
    return jpeg_bytes(reduced(image, most_width, height), most_width);
  }
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  JpegErrors errors;
  jpeg_compress_struct jpeg{};
  jpeg.err = &errors.base;
  const bool good = compress(image, jpeg, errors, &bytes, &size);
  jpeg_destroy_compress(&jpeg);
  const std::unique_ptr<unsigned char, decltype(&std::free)> owner(bytes, &std::free);
  if (!good)
    throw std::runtime_error(std::string("an image cannot become a JPEG: ") + errors.message);
  return {bytes, bytes + size};
}

}  // namespace chasles
