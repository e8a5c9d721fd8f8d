#include "images.hpp"

#include <spdlog/spdlog.h>

#include <chasles/data/bags/ros_image.hpp>
#include <chasles/data/image_range.hpp>

namespace chasles::bridge {
namespace {

std::string_view view(const dds_sequence_octet& bytes) {
  return {reinterpret_cast<const char*>(bytes._buffer), bytes._length};
}

}  // namespace

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

GrayImage ImageDecoder::decode(const ImageMessage& message) {
  const RosImage image{.height = message.height,
                       .width = message.width,
                       .encoding = message.encoding,
                       .big_endian = message.is_bigendian != 0,
                       .step = message.step,
                       .data = view(message.data)};
  return grey_image(image, size_, bits_of(image), where_);
}

GrayImage ImageDecoder::decode(const CompressedImageMessage& message) {
  const std::string_view bytes = view(message.data);
  const bool deep = stated_image(bytes, where_).deep;
  return decode_image(bytes, size_, where_, deep ? bits_of(bytes) : kAllBits);
}

}  // namespace chasles::bridge
