#include <cstdint>
#include <optional>
#include <zlib.h>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <chasles/data/bytes.hpp>
#include <chasles/data/image_decode.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>

// A decoder returns a grey lower half for half a JPEG, and prints its findings about a PNG.
// Therefore the structure of the files is checked first.
namespace chasles {
namespace {

constexpr std::string_view kPng = "\x89PNG\r\n\x1a\n";
constexpr std::string_view kJpeg = "\xff\xd8\xff";
constexpr std::int64_t kMostPixels = 100'000'000;
constexpr std::size_t kFrame = 12;  // length, name and check sum of a PNG's chunk

// Big-endian.
std::uint32_t number(std::string_view bytes, std::size_t at, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8 | byte_at(bytes, at + i);
  return value;
}

// The check sum of PNG's annex D is that of zlib.
std::uint32_t check_sum(std::string_view bytes) {
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  return static_cast<std::uint32_t>(crc32_z(0, data, bytes.size()));
}

[[noreturn]] void damaged(const std::string& where, const std::string& how) {
  throw InputError(fmt::format("{}: {}: the image is damaged, copy it again", where, how));
}

void check_png(std::string_view bytes, const std::string& where) {
  for (std::size_t at = kPng.size();;) {
    if (bytes.size() < at + kFrame) damaged(where, "the PNG file is truncated");
    const std::size_t size = number(bytes, at, 4);
    if (size > bytes.size() - at - kFrame) damaged(where, "the PNG file is truncated");
    const std::string_view chunk = bytes.substr(at + 4, size + 4);
    if (check_sum(chunk) != number(bytes, at + 8 + size, 4)) {
      damaged(where, fmt::format("the check sum of the PNG's part at byte {} is wrong", at));
    }
    if (chunk.starts_with("IEND")) return;
    at += size + kFrame;
  }
}

// Walks through the segments up to the picture itself by their lengths; the frame header (SOF)
// contains the size.
std::optional<ImageSize> jpeg_size(std::string_view bytes) {
  for (std::size_t at = 2; at + 9 <= bytes.size() && byte_at(bytes, at) == 0xff;) {
    const std::uint32_t marker = byte_at(bytes, at + 1);
    if (marker == 0xff) {
      ++at;
      continue;
    }
    const bool frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) {
      return ImageSize{.width = static_cast<int>(number(bytes, at + 7, 2)),
                       .height = static_cast<int>(number(bytes, at + 5, 2))};
    }
    at += 2 + number(bytes, at + 2, 2);
  }
  return std::nullopt;
}

void check_jpeg(std::string_view bytes, const std::string& where) {
  // Some writers pad with zeros.
  const std::size_t last = bytes.find_last_not_of('\0');
  if (last == std::string_view::npos || !bytes.substr(0, last + 1).ends_with("\xff\xd9")) {
    damaged(where, "the JPEG file is truncated");
  }
}

cv::Mat decode(std::string_view bytes, const std::string& where) {
  const std::vector<std::uint8_t> buffer(bytes.begin(), bytes.end());
  try {
    return cv::imdecode(buffer, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& error) {
    damaged(where, "cannot be decoded (" + error.err + ")");
  }
}

}  // namespace

ImageSize stated_size(std::string_view bytes, const std::string& where) {
  if (bytes.starts_with(kPng)) {
    if (bytes.size() < 33) damaged(where, "the PNG file is truncated");
    const std::uint32_t width = number(bytes, 16, 4), height = number(bytes, 20, 4);
    if (width > 0x7fffffff || height > 0x7fffffff) damaged(where, "the PNG states an absurd size");
    return {.width = static_cast<int>(width), .height = static_cast<int>(height)};
  }
  if (bytes.starts_with(kJpeg)) {
    if (const auto size = jpeg_size(bytes)) return *size;
    damaged(where, "the JPEG file has no frame header");
  }
  throw InputError(fmt::format("{}: {}, expected a PNG or JPEG image", where,
                               bytes.empty() ? "is empty" : "is of no known kind"));
}

GrayImage decode_image(std::string_view bytes, const ImageSize& expected,
                       const std::string& where) {
  const ImageSize size = stated_size(bytes, where);
  if (size != expected) {
    throw InputError(fmt::format("{}: is {} x {} pixels, expected {} x {} as in the calibration",
                                 where, size.width, size.height, expected.width, expected.height));
  }
  if (std::int64_t{size.width} * size.height > kMostPixels) {
    throw InputError(fmt::format("{}: states {} x {} pixels, expected at most {} in all", where,
                                 size.width, size.height, kMostPixels));
  }
  if (bytes.starts_with(kPng)) {
    check_png(bytes, where);
  } else {
    check_jpeg(bytes, where);
  }
  const cv::Mat image = decode(bytes, where);
  if (image.cols != size.width || image.rows != size.height || !image.isContinuous()) {
    damaged(where, "cannot be decoded");
  }
  return {.width = size.width, .height = size.height, .pixels = {image.datastart, image.dataend}};
}

GrayImage read_image(const std::filesystem::path& file, const ImageSize& expected) {
  return decode_image(read_file(file), expected, file.string());
}

}  // namespace chasles
