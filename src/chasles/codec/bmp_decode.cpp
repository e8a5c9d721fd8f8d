#include <fmt/format.h>

#include <chasles/codec/bytes.hpp>
#include <chasles/codec/image_kinds.hpp>

// Windows' BMP without compression: a palette of up to 256 colours, 24 or 32 bits.
namespace chasles {
namespace {

constexpr std::size_t kBmpFileHeader = 14;
constexpr std::uint32_t kUncompressed = 0, kBitFields = 3;

std::uint32_t bmp_number(std::string_view bytes, std::size_t at, std::size_t size = 4) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value |= byte_at(bytes, at + i) << (8 * i);
  return value;
}

struct BmpHeader {
  ImageSize size;
  bool downwards = false;  // the rows begin at the top
  std::uint32_t depth = 8;
  std::size_t colours = 0, palette = 0, pixels = 0;  // number, and positions in the file

  std::size_t row_bytes() const {
    return (static_cast<std::size_t>(size.width) * depth + 31) / 32 * 4;
  }
};

// A kind that is read: the channels of 32 bits must be where they are without fields.
void check_bmp_kind(std::string_view bytes, std::uint32_t depth, const std::string& where) {
  const std::uint32_t compression = bmp_number(bytes, 30);
  const bool usual_fields = depth == 32 && compression == kBitFields && bytes.size() >= 66 &&
                            bmp_number(bytes, 54) == 0xff0000 && bmp_number(bytes, 58) == 0xff00 &&
                            bmp_number(bytes, 62) == 0xff;
  const bool known = depth == 1 || depth == 4 || depth == 8 || depth == 24 || depth == 32;
  if (known && (compression == kUncompressed || usual_fields)) return;
  unsupported_image(where,
                    fmt::format("is a BMP of {} bits a pixel, compression {}", depth, compression),
                    "a palette, 24 or 32 bits without compression");
}

BmpHeader bmp_header(std::string_view bytes, const std::string& where) {
  if (bytes.size() < 54) damaged_image(where, "the BMP file is truncated");
  const std::size_t header = bmp_number(bytes, kBmpFileHeader);
  if (header < 40 || header > 124) {
    unsupported_image(where, fmt::format("is a BMP with a header of {} bytes", header),
                      "one of 40 to 124");
  }
  const auto width = static_cast<std::int32_t>(bmp_number(bytes, 18));
  const auto height = static_cast<std::int32_t>(bmp_number(bytes, 22));
  BmpHeader bmp{.size = checked_size(width, height < 0 ? -std::int64_t{height} : height, where),
                .downwards = height < 0,
                .depth = bmp_number(bytes, 28, 2),
                .colours = 0,
                .palette = kBmpFileHeader + header,
                .pixels = bmp_number(bytes, 10)};
  check_bmp_kind(bytes, bmp.depth, where);
  if (bmp.depth <= 8) {
    const std::uint32_t stated = bmp_number(bytes, 46);
    bmp.colours = stated == 0 || stated > 1u << bmp.depth ? 1u << bmp.depth : stated;
  }
  return bmp;
}

std::uint8_t bmp_grey(std::string_view bytes, std::size_t at) {
  return static_cast<std::uint8_t>(
      grey_of_colour(byte_at(bytes, at + 2), byte_at(bytes, at + 1), byte_at(bytes, at)));
}

std::vector<std::uint8_t> bmp_palette(std::string_view bytes, const BmpHeader& bmp) {
  std::vector<std::uint8_t> greys;
  for (std::size_t i = 0; i < bmp.colours; ++i) {
    greys.push_back(bmp_grey(bytes, bmp.palette + 4 * i));
  }
  return greys;
}

bool is_bmp(std::string_view bytes) { return bytes.starts_with("BM"); }

StatedImage stated_bmp(std::string_view bytes, const std::string& where) {
  return {.size = bmp_header(bytes, where).size};
}

GreyPixels decode_bmp(std::string_view bytes, const std::string& where) {
  const BmpHeader bmp = bmp_header(bytes, where);
  const auto width = static_cast<std::size_t>(bmp.size.width);
  const auto height = static_cast<std::size_t>(bmp.size.height);
  if (bytes.size() < bmp.palette + 4 * bmp.colours || bytes.size() < bmp.pixels ||
      (bytes.size() - bmp.pixels) / height < bmp.row_bytes()) {
    damaged_image(where, "the BMP file is truncated");
  }
  const std::vector<std::uint8_t> greys = bmp_palette(bytes, bmp);
  GreyPixels pixels;
  pixels.shallow.reserve(width * height);
  for (std::size_t y = 0; y < height; ++y) {
    const std::size_t row = bmp.pixels + (bmp.downwards ? y : height - 1 - y) * bmp.row_bytes();
    for (std::size_t x = 0; x < width; ++x) {
      if (bmp.depth >= 24) {
        pixels.shallow.push_back(bmp_grey(bytes, row + x * bmp.depth / 8));
        continue;
      }
      const std::size_t bit = x * bmp.depth;
      const std::uint32_t value =
          byte_at(bytes, row + bit / 8) >> (8 - bmp.depth - bit % 8) & ((1u << bmp.depth) - 1);
      if (value >= greys.size()) damaged_image(where, "a pixel's colour is not in the palette");
      pixels.shallow.push_back(greys[value]);
    }
  }
  return pixels;
}

}  // namespace

ImageKind bmp_kind() {
  return {.name = "BMP", .is = is_bmp, .stated = stated_bmp, .decode = decode_bmp};
}

}  // namespace chasles
