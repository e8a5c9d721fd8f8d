#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <chasles/codec/image_kinds.hpp>

namespace chasles {

inline constexpr std::string_view kPngStart = "\x89PNG\r\n\x1a\n";

/// The kinds of a PNG's pixels.
enum PngColour : std::uint32_t { kGrey, kColour = 2, kPalette, kGreyAlpha, kColourAlpha = 6 };

/// The header of a PNG.
struct PngHeader {
  ImageSize size;
  std::uint32_t depth = 8;  ///< bits for each value
  std::uint32_t colour = kGrey;
  bool interlaced = false;

  std::size_t channels() const {
    return colour == kColourAlpha ? 4 : colour == kColour ? 3 : colour == kGreyAlpha ? 2 : 1;
  }
  std::size_t row_bytes(std::size_t width) const { return (width * channels() * depth + 7) / 8; }
  std::size_t pixel_bytes() const { return std::max<std::size_t>(1, channels() * depth / 8); }
};

/// Reads the header of a PNG; `bytes` start with kPngStart. Throws InputError, as do the others.
PngHeader png_header(std::string_view bytes, const std::string& where);

/// The parts of a PNG that its pixels need.
struct PngParts {
  std::string deflated;      ///< by zlib
  std::string_view palette;  ///< red, green and blue of each of its colours
};

/// Collects them. Compares the check sums of all parts.
PngParts png_parts(std::string_view bytes, const std::string& where);

}  // namespace chasles
