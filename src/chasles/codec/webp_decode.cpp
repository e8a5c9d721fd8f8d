#include <webp/decode.h>

#include <chasles/codec/image_kinds.hpp>

// WebP by libwebp, whose pixels are the same on any processor: lossy and lossless, no animations.
namespace chasles {
namespace {

const std::uint8_t* webp_data(std::string_view bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

bool is_webp(std::string_view bytes) {
  return bytes.starts_with("RIFF") && bytes.size() >= 12 && bytes.substr(8, 4) == "WEBP";
}

StatedImage webp_stated(std::string_view bytes, const std::string& where) {
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(webp_data(bytes), bytes.size(), &features) != VP8_STATUS_OK) {
    damaged_image(where, "the header of the WebP is damaged");
  }
  if (features.has_animation != 0) {
    unsupported_image(where, "is an animated WebP", "one of a single picture");
  }
  return {.size = checked_size(features.width, features.height, where)};
}

GreyPixels webp_decode(std::string_view bytes, const std::string& where) {
  const ImageSize size = webp_stated(bytes, where).size;
  std::vector<std::uint8_t> rgb(3 * pixel_count(size));
  if (WebPDecodeRGBInto(webp_data(bytes), bytes.size(), rgb.data(), rgb.size(), 3 * size.width) ==
      nullptr) {
    damaged_image(where, "the WebP is truncated or cannot be decoded");
  }
  GreyPixels pixels;
  pixels.shallow.reserve(pixel_count(size));
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    pixels.shallow.push_back(
        static_cast<std::uint8_t>(grey_of_colour(rgb[i], rgb[i + 1], rgb[i + 2])));
  }
  return pixels;
}

}  // namespace

ImageKind webp_kind() {
  return {.name = "WebP", .is = is_webp, .stated = webp_stated, .decode = webp_decode};
}

}  // namespace chasles
