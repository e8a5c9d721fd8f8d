#pragma once

#include <span>
#include <string>
#include <vector>

#include <chasles/codec/png_file.hpp>

namespace chasles {

/// The images of an interlaced PNG: each has the pixels from (x, y) on, dx and dy apart.
struct PngPass {
  std::size_t x, y, dx, dy;

  std::size_t width(const PngHeader& png) const {
    return (static_cast<std::size_t>(png.size.width) + dx - 1 - x) / dx;
  }
  std::size_t height(const PngHeader& png) const {
    return (static_cast<std::size_t>(png.size.height) + dy - 1 - y) / dy;
  }
  // Of its rows, each with the byte of its filter.
  std::size_t bytes(const PngHeader& png) const {
    return width(png) == 0 ? 0 : height(png) * (1 + png.row_bytes(width(png)));
  }
};

/// Writes rows of a PNG as grey; transparency is ignored.
class PngGreys {
 public:
  PngGreys(const PngHeader& png, std::string_view palette, const std::string& where);

  /// Row y of a pass. Throws InputError for a colour that is not in the palette.
  void write(std::span<const std::uint8_t> row, std::size_t y, const PngPass& pass);

  GreyPixels pixels;

 private:
  void write_from_table(std::span<const std::uint8_t> row, std::size_t count, std::uint8_t* out,
                        std::size_t step) const;

  PngHeader png_;
  std::vector<std::uint8_t> greys_;  // of each colour of the palette, or value of fewer than 8 bits
  std::string where_;
};

}  // namespace chasles
