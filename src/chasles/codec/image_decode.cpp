#include <algorithm>
#include <array>
#include <cstdint>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/image_kinds.hpp>
#include <chasles/codec/image_range.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

constexpr std::int64_t kMostPixels = 100'000'000;

ImageKind kind_of(std::string_view bytes, const std::string& where) {
  for (const ImageKind& kind :
       {png_kind(), jpeg_kind(), pgm_kind(), bmp_kind(), tiff_kind(), webp_kind()}) {
    if (kind.is(bytes)) return kind;
  }
  throw InputError(fmt::format("{}: {}, expected a {} image", where,
                               bytes.empty() ? "is empty" : "is of no known kind",
                               kImageKindNames));
}

GreyPixels decode_pixels(std::string_view bytes, const ImageSize& expected,
                         const std::string& where) {
  const ImageKind kind = kind_of(bytes, where);
  const ImageSize size = kind.stated(bytes, where).size;
  if (size != expected) {
    throw ImageSizeError(
        fmt::format("{}: is {} x {} pixels, expected {} x {} as in the calibration", where,
                    size.width, size.height, expected.width, expected.height));
  }
  if (std::int64_t{size.width} * size.height > kMostPixels) {
    throw InputError(fmt::format("{}: states {} x {} pixels, expected at most {} in all", where,
                                 size.width, size.height, kMostPixels));
  }
  GreyPixels pixels = kind.decode(bytes, where);
  if (std::max(pixels.shallow.size(), pixels.deep.size()) != pixel_count(size)) {
    damaged_image(where, fmt::format("the {} cannot be decoded", kind.name));
  }
  return pixels;
}

std::vector<std::uint8_t> high_bytes(const std::vector<std::uint16_t>& deep, int bits) {
  std::vector<std::uint8_t> pixels(deep.size());
  std::transform(deep.begin(), deep.end(), pixels.begin(), [bits](std::uint16_t value) {
    return static_cast<std::uint8_t>(std::min(value >> (bits - 8), 255));
  });
  return pixels;
}

}  // namespace

const char* const kImageKindNames = "PNG, JPEG, PGM, BMP, TIFF or WebP";

void damaged_image(const std::string& where, const std::string& how) {
  throw InputError(fmt::format("{}: {}: the image is damaged, copy it again", where, how));
}

void unsupported_image(const std::string& where, const std::string& how,
                       const std::string& expected) {
  throw InputError(fmt::format("{}: {}, expected {}: convert the images", where, how, expected));
}

ImageSize checked_size(std::int64_t width, std::int64_t height, const std::string& where) {
  if (width < 1 || height < 1 || width > 0x7fffffff || height > 0x7fffffff) {
    damaged_image(where, fmt::format("states an absurd size, {} x {} pixels", width, height));
  }
  return {.width = static_cast<int>(width), .height = static_cast<int>(height)};
}

bool is_image_name(const std::string& name) {
  static constexpr std::array<std::string_view, 8> kEndings{".png", ".jpg", ".jpeg", ".pgm",
                                                            ".bmp", ".tif", ".tiff", ".webp"};
  if (name.starts_with('.')) return false;
  const std::string ending = lower_case(std::filesystem::path(name).extension().string());
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

StatedImage stated_image(std::string_view bytes, const std::string& where) {
  return kind_of(bytes, where).stated(bytes, where);
}

ImageSize stated_size(std::string_view bytes, const std::string& where) {
  return stated_image(bytes, where).size;
}

GrayImage decode_image(std::string_view bytes, const ImageSize& expected, const std::string& where,
                       int bits) {
  GreyPixels pixels = decode_pixels(bytes, expected, where);
  return {
      .width = expected.width,
      .height = expected.height,
      .pixels = pixels.deep.empty() ? std::move(pixels.shallow) : high_bytes(pixels.deep, bits)};
}

GrayImage read_image(const std::filesystem::path& file, const ImageSize& expected, int bits) {
  return decode_image(read_file(file), expected, file.string(), bits);
}

std::optional<int> largest_deep_value(std::string_view bytes, const ImageSize& expected,
                                      const std::string& where) {
  if (!stated_image(bytes, where).deep) return std::nullopt;
  const std::vector<std::uint16_t> deep = decode_pixels(bytes, expected, where).deep;
  return deep.empty() ? std::nullopt : std::optional<int>(largest_but_hot(deep));
}

}  // namespace chasles
