#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <tiffio.h>

#include <fmt/format.h>

#include <chasles/codec/image_kinds.hpp>

// TIFF by libtiff (4.5 or later), out of memory: grey or colour of 8 or 16 bits in strips.
namespace chasles {
namespace {

constexpr tmsize_t kMostAtOnce = 1'000'000'000;  // bytes that libtiff may allocate at a time

// The bytes of a file, which libtiff reads by the functions below, and its first error.
struct TiffBytes {
  std::string_view bytes;
  std::size_t at = 0;
  std::string error;
};

TiffBytes& tiff_bytes(thandle_t handle) { return *static_cast<TiffBytes*>(handle); }

tmsize_t read_tiff(thandle_t handle, void* to, tmsize_t size) {
  TiffBytes& file = tiff_bytes(handle);
  const std::size_t left = file.bytes.size() - std::min(file.at, file.bytes.size());
  const std::size_t count = std::min(left, static_cast<std::size_t>(size));
  if (count > 0) std::memcpy(to, file.bytes.data() + file.at, count);
  file.at += count;
  return static_cast<tmsize_t>(count);
}

tmsize_t write_no_tiff(thandle_t, void*, tmsize_t) { return 0; }

toff_t seek_tiff(thandle_t handle, toff_t offset, int from) {
  TiffBytes& file = tiff_bytes(handle);
  const std::size_t base = from == SEEK_CUR ? file.at : from == SEEK_END ? file.bytes.size() : 0;
  file.at = base + offset;
  return file.at;
}

int close_tiff(thandle_t) { return 0; }

toff_t tiff_size(thandle_t handle) { return tiff_bytes(handle).bytes.size(); }

int map_tiff(thandle_t handle, void** bytes, toff_t* size) {
  const std::string_view all = tiff_bytes(handle).bytes;
  *bytes = const_cast<char*>(all.data());  // opened for reading only
  *size = all.size();
  return 1;
}

void unmap_tiff(thandle_t, void*, toff_t) {}

int keep_tiff_error(TIFF*, void* file, const char*, const char* format, va_list arguments) {
  std::string& error = static_cast<TiffBytes*>(file)->error;
  char text[200] = "";
  std::vsnprintf(text, sizeof text, format, arguments);
  if (error.empty()) error = text;
  return 1;  // not to be printed
}

int keep_no_warning(TIFF*, void*, const char*, const char*, va_list) { return 1; }

using Tiff = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

Tiff open_tiff(TiffBytes& file, const std::string& where) {
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(
      TIFFOpenOptionsAlloc(), &TIFFOpenOptionsFree);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kMostAtOnce);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_tiff_error, &file);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), keep_no_warning, nullptr);
  Tiff tiff(TIFFClientOpenExt("TIFF", "r", &file, read_tiff, write_no_tiff, seek_tiff, close_tiff,
                              tiff_size, map_tiff, unmap_tiff, options.get()),
            &TIFFClose);
  if (!tiff) damaged_image(where, fmt::format("the TIFF cannot be opened ({})", file.error));
  return tiff;
}

std::uint16_t tiff_field(const Tiff& tiff, std::uint32_t tag) {
  std::uint16_t value = 0;
  return TIFFGetFieldDefaulted(tiff.get(), tag, &value) == 1 ? value : std::uint16_t{0};
}

struct TiffHeader {
  ImageSize size;
  std::size_t channels = 1, depth = 8;
  bool colour = false, white_is_zero = false;
};

void check_tiff_kind(const Tiff& tiff, const TiffHeader& header, const std::string& where) {
  const std::uint16_t light = tiff_field(tiff, TIFFTAG_PHOTOMETRIC);
  const std::uint16_t compression = tiff_field(tiff, TIFFTAG_COMPRESSION);
  const std::uint16_t form = tiff_field(tiff, TIFFTAG_SAMPLEFORMAT);
  const bool packed = compression == COMPRESSION_NONE || compression == COMPRESSION_LZW ||
                      compression == COMPRESSION_PACKBITS ||
                      compression == COMPRESSION_ADOBE_DEFLATE ||
                      compression == COMPRESSION_DEFLATE;
  const bool channels = header.colour ? header.channels == 3 || header.channels == 4
                                      : header.channels == 1 || header.channels == 2;
  const bool whole = form == SAMPLEFORMAT_UINT && (header.depth == 8 || header.depth == 16);
  const bool light_known = light == PHOTOMETRIC_MINISBLACK || light == PHOTOMETRIC_MINISWHITE ||
                           light == PHOTOMETRIC_RGB;
  const bool together =
      header.channels == 1 || tiff_field(tiff, TIFFTAG_PLANARCONFIG) == PLANARCONFIG_CONTIG;
  if (packed && channels && whole && light_known && together && !TIFFIsTiled(tiff.get())) return;
  unsupported_image(
      where,
      fmt::format("is a {}TIFF of {} channels of {} bits, photometric {}, compression {}",
                  TIFFIsTiled(tiff.get()) ? "tiled " : "", header.channels, header.depth, light,
                  compression),
      "grey or RGB of 8 or 16 bits in strips, without compression or with LZW, deflate or "
      "PackBits");
}

TiffHeader tiff_header(const Tiff& tiff, const std::string& where) {
  std::uint32_t width = 0, height = 0;
  TIFFGetField(tiff.get(), TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(tiff.get(), TIFFTAG_IMAGELENGTH, &height);
  const std::uint16_t light = tiff_field(tiff, TIFFTAG_PHOTOMETRIC);
  const TiffHeader header{.size = checked_size(width, height, where),
                          .channels = tiff_field(tiff, TIFFTAG_SAMPLESPERPIXEL),
                          .depth = tiff_field(tiff, TIFFTAG_BITSPERSAMPLE),
                          .colour = light == PHOTOMETRIC_RGB,
                          .white_is_zero = light == PHOTOMETRIC_MINISWHITE};
  check_tiff_kind(tiff, header, where);
  return header;
}

// The rows' values have the processor's order of bytes.
template <typename Value>
std::vector<Value> tiff_greys(const Tiff& tiff, const TiffHeader& header, const TiffBytes& file,
                              const std::string& where) {
  const auto width = static_cast<std::size_t>(header.size.width);
  std::vector<Value> greys, row(width * header.channels);
  if (TIFFScanlineSize(tiff.get()) != static_cast<tmsize_t>(row.size() * sizeof(Value))) {
    damaged_image(where, "the TIFF's rows do not have the size of its pixels");
  }
  greys.reserve(pixel_count(header.size));
  for (int y = 0; y < header.size.height; ++y) {
    if (TIFFReadScanline(tiff.get(), row.data(), static_cast<std::uint32_t>(y), 0) != 1) {
      damaged_image(where, fmt::format("the TIFF cannot be decoded ({})", file.error));
    }
    for (auto at = row.begin(); at != row.end();
         at += static_cast<std::ptrdiff_t>(header.channels)) {
      const auto grey = static_cast<Value>(header.colour ? grey_of_colour(at[0], at[1], at[2])
                                                         : std::uint32_t{at[0]});
      greys.push_back(header.white_is_zero ? static_cast<Value>(~grey) : grey);
    }
  }
  return greys;
}

bool is_tiff(std::string_view bytes) {
  using namespace std::string_view_literals;
  return bytes.starts_with("II*\0"sv) || bytes.starts_with("MM\0*"sv) ||
         bytes.starts_with("II+\0"sv) || bytes.starts_with("MM\0+"sv);
}

StatedImage stated_tiff(std::string_view bytes, const std::string& where) {
  TiffBytes file{.bytes = bytes, .at = 0, .error = {}};
  const TiffHeader header = tiff_header(open_tiff(file, where), where);
  return {.size = header.size, .deep = header.depth == 16};
}

GreyPixels decode_tiff(std::string_view bytes, const std::string& where) {
  TiffBytes file{.bytes = bytes, .at = 0, .error = {}};
  const Tiff tiff = open_tiff(file, where);
  const TiffHeader header = tiff_header(tiff, where);
  GreyPixels pixels;
  if (header.depth == 16) {
    pixels.deep = tiff_greys<std::uint16_t>(tiff, header, file, where);
  } else {
    pixels.shallow = tiff_greys<std::uint8_t>(tiff, header, file, where);
  }
  return pixels;
}

}  // namespace

ImageKind tiff_kind() {
  return {.name = "TIFF", .is = is_tiff, .stated = stated_tiff, .decode = decode_tiff};
}

}  // namespace chasles
