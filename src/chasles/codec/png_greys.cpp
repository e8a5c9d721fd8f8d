#include <algorithm>

#include <chasles/codec/bytes.hpp>
#include <chasles/codec/png_greys.hpp>

namespace chasles {
namespace {

// The grey of each value: of a palette's colours, or of fewer than 8 bits.
std::vector<std::uint8_t> png_greys(const PngHeader& png, std::string_view palette) {
  std::vector<std::uint8_t> greys;
  if (png.colour == kPalette) {
    for (std::size_t i = 0; i + 3 <= palette.size() && greys.size() < 256; i += 3) {
      greys.push_back(static_cast<std::uint8_t>(
          grey_of_colour(byte_at(palette, i), byte_at(palette, i + 1), byte_at(palette, i + 2))));
    }
  } else if (png.depth < 8) {
    const std::uint32_t most = (1u << png.depth) - 1;
    for (std::uint32_t v = 0; v <= most; ++v) {
      greys.push_back(static_cast<std::uint8_t>(v * 255 / most));
    }
  }
  return greys;
}

// Values of kBytes bytes, the high one first.
template <std::size_t kBytes, typename Grey>
void write_values(std::span<const std::uint8_t> row, std::size_t channels, std::size_t count,
                  Grey* out, std::size_t step) {
  const auto value = [](const std::uint8_t* at) {
    return kBytes == 1 ? std::uint32_t{at[0]} : std::uint32_t{at[0]} << 8 | at[kBytes - 1];
  };
  const std::uint8_t* at = row.data();
  for (std::size_t i = 0; i < count; ++i, at += channels * kBytes) {
    out[i * step] = static_cast<Grey>(
        channels < 3 ? value(at)
                     : grey_of_colour(value(at), value(at + kBytes), value(at + 2 * kBytes)));
  }
}

}  // namespace

PngGreys::PngGreys(const PngHeader& png, std::string_view palette, const std::string& where)
    : png_(png), greys_(png_greys(png, palette)), where_(where) {
  if (png.depth == 16) {
    pixels.deep.resize(pixel_count(png.size));
  } else {
    pixels.shallow.resize(pixel_count(png.size));
  }
}

void PngGreys::write(std::span<const std::uint8_t> row, std::size_t y, const PngPass& pass) {
  const std::size_t count = pass.width(png_);
  const std::size_t first =
      (pass.y + y * pass.dy) * static_cast<std::size_t>(png_.size.width) + pass.x;
  if (png_.depth == 16) {
    write_values<2>(row, png_.channels(), count, pixels.deep.data() + first, pass.dx);
  } else if (!greys_.empty() || png_.colour == kPalette) {
    write_from_table(row, count, pixels.shallow.data() + first, pass.dx);
  } else if (png_.colour == kGrey && pass.dx == 1) {
    std::copy_n(row.data(), count, pixels.shallow.data() + first);
  } else {
    write_values<1>(row, png_.channels(), count, pixels.shallow.data() + first, pass.dx);
  }
}

void PngGreys::write_from_table(std::span<const std::uint8_t> row, std::size_t count,
                                std::uint8_t* out, std::size_t step) const {
  const std::size_t per_byte = 8 / png_.depth;
  const std::uint32_t most = (1u << png_.depth) - 1;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t shift = 8 - png_.depth * (i % per_byte + 1);
    const std::uint32_t value = row[i / per_byte] >> shift & most;
    if (value >= greys_.size()) damaged_image(where_, "a pixel's colour is not in the palette");
    out[i * step] = greys_[value];
  }
}

}  // namespace chasles
