#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <chasles/camera/image_frame.hpp>

namespace chasles {

/// The size of an image.
struct ImageSize {
  int width = 0, height = 0;  ///< [px]
  bool operator==(const ImageSize&) const = default;
};

/// The size in the header of a PNG or JPEG. Throws InputError, starting with `where`, for anything
/// else.
ImageSize stated_size(std::string_view bytes, const std::string& where);

/// Decodes a PNG or JPEG; colours and 16 bits become 8 bits of grey. Throws InputError, starting
/// with `where`, for bytes of another kind, truncated bytes, a wrong check sum (PNG; a JPEG has
/// none), a size other than `expected`, and more than 10^8 pixels. The size is checked before
/// decoding.
GrayImage decode_image(std::string_view bytes, const ImageSize& expected, const std::string& where);

/// The same for a file.
GrayImage read_image(const std::filesystem::path& file, const ImageSize& expected);

}  // namespace chasles
