#include <libdeflate.h>

#include <fmt/format.h>

#include <chasles/codec/bytes.hpp>
#include <chasles/codec/png_file.hpp>

namespace chasles {
namespace {

constexpr std::size_t kChunkFrame = 12;  // length, name and check sum of a chunk

std::uint32_t png_number(std::string_view bytes, std::size_t at) {
  return byte_at(bytes, at) << 24 | byte_at(bytes, at + 1) << 16 | byte_at(bytes, at + 2) << 8 |
         byte_at(bytes, at + 3);
}

bool is_png_depth(std::uint32_t colour, std::uint32_t depth) {
  const bool small = depth == 1 || depth == 2 || depth == 4;
  switch (colour) {
    case kGrey:
      return small || depth == 8 || depth == 16;
    case kPalette:
      return small || depth == 8;
    case kColour:
    case kGreyAlpha:
    case kColourAlpha:
      return depth == 8 || depth == 16;
    default:
      return false;
  }
}

}  // namespace

PngHeader png_header(std::string_view bytes, const std::string& where) {
  if (bytes.size() < 33) damaged_image(where, "the PNG file is truncated");
  if (bytes.substr(8, 8) != std::string_view("\0\0\0\x0dIHDR", 8)) {
    damaged_image(where, "the PNG file does not begin with its header");
  }
  const PngHeader header{
      .size = checked_size(png_number(bytes, 16), png_number(bytes, 20), where),
      .depth = byte_at(bytes, 24),
      .colour = byte_at(bytes, 25),
      .interlaced = byte_at(bytes, 28) == 1,
  };
  if (!is_png_depth(header.colour, header.depth) || byte_at(bytes, 26) != 0 ||
      byte_at(bytes, 27) != 0 || byte_at(bytes, 28) > 1) {
    damaged_image(where, "the PNG's header states a kind that PNG does not have");
  }
  return header;
}

PngParts png_parts(std::string_view bytes, const std::string& where) {
  PngParts parts;
  parts.deflated.reserve(bytes.size());
  for (std::size_t at = kPngStart.size();;) {
    if (bytes.size() < at + kChunkFrame) damaged_image(where, "the PNG file is truncated");
    const std::size_t size = png_number(bytes, at);
    if (size > bytes.size() - at - kChunkFrame) damaged_image(where, "the PNG file is truncated");
    const std::string_view chunk = bytes.substr(at + 4, size + 4);
    if (libdeflate_crc32(0, chunk.data(), chunk.size()) != png_number(bytes, at + 8 + size)) {
      damaged_image(where, fmt::format("the check sum of the PNG's part at byte {} is wrong", at));
    }
    if (chunk.starts_with("IDAT")) parts.deflated += chunk.substr(4);
    if (chunk.starts_with("PLTE")) parts.palette = chunk.substr(4);
    if (chunk.starts_with("IEND")) return parts;
    at += size + kChunkFrame;
  }
}

}  // namespace chasles
