#pragma once

#include <string>
#include <string_view>
#include <utility>

#include <chasles/bags/ros_messages.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/codec/image_decode.hpp>

namespace chasles {

/// Decodes the images of one camera, as the readers of bags do.
class ImageDecoder {
 public:
  /// `where`: the camera and its topic, for messages. `bits`: in use, of images with 16; 0: as the
  /// first of them shows.
  ImageDecoder(ImageSize size, int bits, std::string where)
      : size_(size), bits_(bits), where_(std::move(where)) {}

  /// Throws InputError as grey_image() and decode_image() do: for an encoding that is not known,
  /// another size than that of the calibration, and damage.
  GrayImage decode(const RosImage& image);
  /// The same for the bytes of a PNG or JPEG.
  GrayImage decode(std::string_view compressed);

 private:
  template <typename Pixels>
  int bits_of(const Pixels& pixels);

  ImageSize size_;
  int bits_;
  std::string where_;
};

}  // namespace chasles
