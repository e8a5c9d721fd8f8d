#include <array>
#include <libdeflate.h>
#include <memory>
#include <new>

#include <chasles/codec/bytes.hpp>
#include <chasles/codec/png_greys.hpp>
#include <chasles/codec/png_rows.hpp>

// PNG by its specification (W3C, second edition), to grey.
namespace chasles {
namespace {

// Adam7.
constexpr std::array<PngPass, 7> kInterlaced{{{0, 0, 8, 8},
                                              {4, 0, 8, 8},
                                              {0, 4, 4, 8},
                                              {2, 0, 4, 4},
                                              {0, 2, 2, 4},
                                              {1, 0, 2, 2},
                                              {0, 1, 1, 2}}};
constexpr std::array<PngPass, 1> kWhole{{{0, 0, 1, 1}}};

std::span<const PngPass> passes_of(const PngHeader& png) {
  return png.interlaced ? std::span<const PngPass>(kInterlaced) : std::span<const PngPass>(kWhole);
}

// The check sum of zlib's format (Adler-32) is compared as well.
std::unique_ptr<std::uint8_t[]> inflate_png(std::string_view deflated, std::size_t expected,
                                            const std::string& where) {
  if (expected / kMostInflation > deflated.size()) {
    damaged_image(where, "the PNG holds fewer pixels than it states");
  }
  std::unique_ptr<std::uint8_t[]> bytes(new std::uint8_t[expected]);  // not set to zero
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> inflater(
      libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
  if (!inflater) throw std::bad_alloc();
  switch (libdeflate_zlib_decompress(inflater.get(), deflated.data(), deflated.size(), bytes.get(),
                                     expected, nullptr)) {
    case LIBDEFLATE_SUCCESS:
      return bytes;
    case LIBDEFLATE_SHORT_OUTPUT:
      damaged_image(where, "the PNG holds fewer pixels than it states");
    case LIBDEFLATE_INSUFFICIENT_SPACE:
      damaged_image(where, "the PNG holds more pixels than it states");
    default:
      damaged_image(where, "the PNG's compressed pixels or their check sum are wrong");
  }
}

bool is_png(std::string_view bytes) { return bytes.starts_with(kPngStart); }

StatedImage stated_png(std::string_view bytes, const std::string& where) {
  const PngHeader header = png_header(bytes, where);
  return {.size = header.size, .deep = header.depth == 16};
}

GreyPixels decode_png(std::string_view bytes, const std::string& where) {
  const PngHeader png = png_header(bytes, where);
  const PngParts parts = png_parts(bytes, where);
  std::size_t all = 0;
  for (const PngPass& pass : passes_of(png)) all += pass.bytes(png);
  const auto filtered = inflate_png(parts.deflated, all, where);
  PngGreys greys(png, parts.palette, where);
  const std::uint8_t* at = filtered.get();
  for (const PngPass& pass : passes_of(png)) {
    const std::size_t size = pass.bytes(png);
    if (size == 0) continue;
    const bool good = unfilter_png_rows(
        {at, size}, png.row_bytes(pass.width(png)), png.pixel_bytes(),
        [&](std::size_t y, std::span<const std::uint8_t> row) { greys.write(row, y, pass); });
    if (!good) damaged_image(where, "a row of the PNG has a filter that PNG does not have");
    at += size;
  }
  return std::move(greys.pixels);
}

}  // namespace

ImageKind png_kind() {
  return {.name = "PNG", .is = is_png, .stated = stated_png, .decode = decode_png};
}

}  // namespace chasles
