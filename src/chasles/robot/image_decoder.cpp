#include <optional>

#include <spdlog/spdlog.h>

#include <chasles/bags/ros_image.hpp>
#include <chasles/codec/image_range.hpp>
#include <chasles/robot/image_decoder.hpp>

namespace chasles {

template <typename Pixels>
int ImageDecoder::bits_of(const Pixels& pixels) {
  if (bits_ != 0) return bits_;
  const auto largest = [&](std::size_t) { return largest_deep_value(pixels, size_, where_); };
  if (!largest(0)) return kAllBits;  // 8 bits for each value
  const std::optional<DeepRange> range = deep_range(1, largest);
  bits_ = range->bits;
  spdlog::info("{}", deep_remark(*range, where_));
  return bits_;
}

GrayImage ImageDecoder::decode(const RosImage& image) {
  return grey_image(image, size_, bits_of(image), where_);
}

GrayImage ImageDecoder::decode(std::string_view compressed) {
  const bool deep = stated_image(compressed, where_).deep;
  return decode_image(compressed, size_, where_, deep ? bits_of(compressed) : kAllBits);
}

}  // namespace chasles
