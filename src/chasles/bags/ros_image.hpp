#pragma once

#include <optional>
#include <string>

#include <chasles/bags/ros_messages.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/codec/image_decode.hpp>

namespace chasles {

/// Throws InputError, starting with `where`, for an encoding that is not known; the message has the
/// list of those that are: grey, colours and Bayer mosaics of 8 and 16 bits, YUV.
void check_encoding(std::string_view encoding, const std::string& where);

/// The largest value of an image of 16 bits; nothing for one of 8 bits. Throws as grey_image()
/// does.
std::optional<int> largest_deep_value(const RosImage& image, const ImageSize& expected,
                                      const std::string& where);

/// The image as 8 bits of grey. Colours become grey by ITU-R BT.601. A Bayer mosaic becomes colours
/// first, each the mean of its nearest pixels (bilinear); all of it in integers, so that the
/// result is the same on every machine. Of YUV images Y is taken. Of 16-bit values, the eight
/// highest of the lowest `bits` bits stay (deep_range); larger values become white. Throws
/// InputError for an unknown encoding, another size than `expected`, and too few bytes.
GrayImage grey_image(const RosImage& image, const ImageSize& expected, int bits,
                     const std::string& where);

}  // namespace chasles
