#include <optional>

#include <fmt/format.h>

#include <chasles/codec/bytes.hpp>
#include <chasles/codec/image_kinds.hpp>
#include <chasles/codec/jpeg_error.hpp>

// JPEG by libjpeg-turbo. It returns a grey lower half for half a file, so the end is checked first.
// Its accurate integer transform, the default, gives the same pixels on any processor.
namespace chasles {
namespace {

constexpr std::string_view kJpegStart = "\xff\xd8\xff";
// A progressive JPEG repeats the picture in scans: many in a small file take minutes.
constexpr int kMostScans = 200;

std::uint32_t jpeg_number(std::string_view bytes, std::size_t at) {
  return byte_at(bytes, at) << 8 | byte_at(bytes, at + 1);
}

// Walks through the segments up to the picture itself by their lengths; the frame header (SOF)
// contains the size.
std::optional<ImageSize> jpeg_size(std::string_view bytes, const std::string& where) {
  for (std::size_t at = 2; at + 9 <= bytes.size() && byte_at(bytes, at) == 0xff;) {
    const std::uint32_t marker = byte_at(bytes, at + 1);
    if (marker == 0xff) {
      ++at;
      continue;
    }
    const bool frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) {
      return checked_size(jpeg_number(bytes, at + 7), jpeg_number(bytes, at + 5), where);
    }
    at += 2 + jpeg_number(bytes, at + 2);
  }
  return std::nullopt;
}

void check_jpeg_end(std::string_view bytes, const std::string& where) {
  // Some writers pad with zeros.
  const std::size_t last = bytes.find_last_not_of('\0');
  if (last == std::string_view::npos || !bytes.substr(0, last + 1).ends_with("\xff\xd9")) {
    damaged_image(where, "the JPEG file is truncated");
  }
}

void stop_at_many_scans(j_common_ptr jpeg) {
  if (reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number > kMostScans) {
    leave_jpeg(jpeg, "it has more than 200 scans");
  }
}

// Plain C: libjpeg jumps out of it at an error. Returns whether all rows were decoded.
bool decompress(std::string_view bytes, const ImageSize& size, jpeg_decompress_struct& jpeg,
                JpegErrors& errors, jpeg_progress_mgr& progress, std::uint8_t* pixels) {
  if (setjmp(errors.jump) != 0) return false;
  jpeg_create_decompress(&jpeg);
  jpeg.progress = &progress;
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()),
               static_cast<unsigned long>(bytes.size()));
  jpeg_read_header(&jpeg, TRUE);
  jpeg.out_color_space = JCS_GRAYSCALE;
  jpeg_start_decompress(&jpeg);
  if (jpeg.output_width != static_cast<JDIMENSION>(size.width) ||
      jpeg.output_height != static_cast<JDIMENSION>(size.height) || jpeg.output_components != 1) {
    return false;
  }
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = pixels + std::size_t{jpeg.output_scanline} * jpeg.output_width;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_decompress(&jpeg);
  return !errors.damaged;
}

bool is_jpeg(std::string_view bytes) { return bytes.starts_with(kJpegStart); }

StatedImage stated_jpeg(std::string_view bytes, const std::string& where) {
  if (const auto size = jpeg_size(bytes, where)) return {.size = *size};
  damaged_image(where, "the JPEG file has no frame header");
}

GreyPixels decode_jpeg(std::string_view bytes, const std::string& where) {
  const ImageSize size = stated_jpeg(bytes, where).size;
  check_jpeg_end(bytes, where);
  GreyPixels pixels;
  pixels.shallow.resize(pixel_count(size));
  JpegErrors errors;
  jpeg_progress_mgr progress{};
  progress.progress_monitor = stop_at_many_scans;
  jpeg_decompress_struct jpeg{};
  jpeg.err = &errors.base;
  const bool good = decompress(bytes, size, jpeg, errors, progress, pixels.shallow.data());
  const bool of_print = jpeg.jpeg_color_space == JCS_CMYK || jpeg.jpeg_color_space == JCS_YCCK;
  jpeg_destroy_decompress(&jpeg);
  if (!good && of_print) unsupported_image(where, "a JPEG in CMYK", "grey levels or RGB");
  if (!good) {
    damaged_image(where, fmt::format("the JPEG cannot be decoded ({})",
                                     *errors.message ? errors.message : "another size inside"));
  }
  return pixels;
}

}  // namespace

ImageKind jpeg_kind() {
  return {.name = "JPEG", .is = is_jpeg, .stated = stated_jpeg, .decode = decode_jpeg};
}

}  // namespace chasles
