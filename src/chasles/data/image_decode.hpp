#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <chasles/camera/image_frame.hpp>

namespace chasles {

/// How large an image has to be, and who says so.
struct ImageSize {
  int width = 0, height = 0;  ///< [px]
  bool operator==(const ImageSize&) const = default;
};

/// The size that the first bytes of a PNG or JPEG state. Throws InputError, which begins with
/// `where`, for anything else.
ImageSize stated_size(std::string_view bytes, const std::string& where);

/// Decodes a PNG or JPEG; colours and 16 bits become 8 bits of grey. Throws InputError, which
/// begins with `where`, for bytes that are of no such kind, are truncated, are not as their check
/// sums say (PNG; a JPEG has none), or show an image of another size than `expected`, which is
/// looked at before anything is decoded, or of more than 10^8 pixels.
GrayImage decode_image(std::string_view bytes, const ImageSize& expected, const std::string& where);

/// The same for a file.
GrayImage read_image(const std::filesystem::path& file, const ImageSize& expected);

}  // namespace chasles
