#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include <chasles/camera/image_frame.hpp>
#include <chasles/codec/image_source.hpp>

namespace chasles {

/// The size of an image.
struct ImageSize {
  int width = 0, height = 0;  ///< [px]
  bool operator==(const ImageSize&) const = default;
};

/// What the header of an image states.
struct StatedImage {
  ImageSize size;
  bool deep = false;  ///< 16 bits for each value, not 8 or fewer
};

/// Images of 16 bits per value whose whole range is used.
inline constexpr int kAllBits = 16;

/// The names of the kinds that are read: "PNG, JPEG, PGM, BMP, TIFF or WebP".
extern const char* const kImageKindNames;

/// Whether a file of this name is an image, by its ending; capital letters do not matter. Hidden
/// files (`._0.png`, which macOS writes beside 0.png) are not.
bool is_image_name(const std::string& name);

/// The header of a PNG, JPEG, PGM, BMP, TIFF or WebP. Throws InputError, starting with `where`, for
/// anything else.
StatedImage stated_image(std::string_view bytes, const std::string& where);
ImageSize stated_size(std::string_view bytes, const std::string& where);

/// Decodes a PNG, JPEG, PGM, BMP, TIFF or WebP to 8 bits of grey. Colours become grey as luma
/// (ITU-R BT.601). Of 16-bit values, the eight highest of the lowest `bits` bits stay; larger
/// values become white. The pixels depend on the bytes alone, on any processor.
///
/// Throws InputError, starting with `where`, for bytes of another kind, truncated bytes, a wrong
/// check sum (PNG; the others have none), and more than 10^8 pixels; ImageSizeError for a size
/// other than `expected`. The size is checked before decoding.
GrayImage decode_image(std::string_view bytes, const ImageSize& expected, const std::string& where,
                       int bits = kAllBits);

/// The same for a file.
GrayImage read_image(const std::filesystem::path& file, const ImageSize& expected,
                     int bits = kAllBits);

/// The largest value of an image of 16 bits, as largest_but_hot(); nothing for one of 8 bits.
/// Throws as decode_image().
std::optional<int> largest_deep_value(std::string_view bytes, const ImageSize& expected,
                                      const std::string& where);

}  // namespace chasles
