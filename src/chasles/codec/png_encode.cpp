#include <cstdint>
#include <libdeflate.h>
#include <memory>
#include <new>

#include <chasles/codec/image_encode.hpp>

namespace chasles {
namespace {

void append_big_endian(std::string& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 255);
}

void append_chunk(std::string& png, const std::string& name, const std::string& content) {
  append_big_endian(png, static_cast<std::uint32_t>(content.size()));
  const std::string chunk = name + content;
  png += chunk;
  append_big_endian(png, libdeflate_crc32(0, chunk.data(), chunk.size()));
}

// The rows, each as the differences to the left neighbour (PNG's filter 1).
std::string filtered_rows(const GrayImage& image) {
  const auto width = static_cast<std::size_t>(image.width);
  std::string rows;
  rows.reserve((width + 1) * static_cast<std::size_t>(image.height));
  for (std::size_t y = 0; y < static_cast<std::size_t>(image.height); ++y) {
    const std::uint8_t* row = image.pixels.data() + y * width;
    rows += '\1';
    for (std::size_t x = 0; x < width; ++x) {
      rows += static_cast<char>(static_cast<std::uint8_t>(row[x] - (x > 0 ? row[x - 1] : 0)));
    }
  }
  return rows;
}

std::string deflated(const std::string& content) {
  constexpr int kFast = 1;
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> deflater(
      libdeflate_alloc_compressor(kFast), &libdeflate_free_compressor);
  if (!deflater) throw std::bad_alloc();
  std::string bytes(libdeflate_zlib_compress_bound(deflater.get(), content.size()), '\0');
  bytes.resize(libdeflate_zlib_compress(deflater.get(), content.data(), content.size(),
                                        bytes.data(), bytes.size()));
  return bytes;
}

}  // namespace

std::string png_bytes(const GrayImage& image) {
  std::string header;
  append_big_endian(header, static_cast<std::uint32_t>(image.width));
  append_big_endian(header, static_cast<std::uint32_t>(image.height));
  header += std::string("\x08\0\0\0\0", 5);  // 8 bits of grey
  std::string png = "\x89PNG\r\n\x1a\n";
  append_chunk(png, "IHDR", header);
  append_chunk(png, "IDAT", deflated(filtered_rows(image)));
  append_chunk(png, "IEND", "");
  return png;
}

}  // namespace chasles
