#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <chasles/codec/image_decode.hpp>

namespace chasles {

// Shared by the decoders of images, one file for each kind. Errors are InputError and start with
// `where`.

/// Decoded pixels, row by row: grey of 8 bits, or of 16. One of the two is empty.
struct GreyPixels {
  std::vector<std::uint8_t> shallow;
  std::vector<std::uint16_t> deep;
};

/// A kind of image file.
struct ImageKind {
  std::string_view name;  ///< "PNG"
  bool (*is)(std::string_view bytes);
  /// What the header states.
  StatedImage (*stated)(std::string_view bytes, const std::string& where);
  /// The pixels; their number is that of the stated size.
  GreyPixels (*decode)(std::string_view bytes, const std::string& where);
};

ImageKind png_kind();
ImageKind jpeg_kind();
ImageKind pgm_kind();
ImageKind bmp_kind();
ImageKind tiff_kind();
ImageKind webp_kind();

/// "WHERE: HOW: the image is damaged, copy it again".
[[noreturn]] void damaged_image(const std::string& where, const std::string& how);
/// "WHERE: HOW, expected EXPECTED: convert the images".
[[noreturn]] void unsupported_image(const std::string& where, const std::string& how,
                                    const std::string& expected);

/// The size, if it is at least 1 x 1 and its sides fit into int.
ImageSize checked_size(std::int64_t width, std::int64_t height, const std::string& where);

/// The number of its pixels.
inline std::size_t pixel_count(const ImageSize& size) {
  return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

/// The grey of a colour of 8 or of 16 bits: 0.299 red + 0.587 green + 0.114 blue in units of 2^-15,
/// rounded down, as libpng does it. Grey stays as it is.
inline std::uint32_t grey_of_colour(std::uint32_t red, std::uint32_t green, std::uint32_t blue) {
  return (9797 * red + 19234 * green + 3737 * blue) >> 15;
}

}  // namespace chasles
