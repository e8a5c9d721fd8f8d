#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include <chasles/data/bytes.hpp>
#include <chasles/data/ros_message.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

// Reads fields from the front of a message.
class Fields {
 public:
  Fields(std::string_view bytes, const std::string& where) : rest_(bytes), where_(&where) {}

  std::string_view bytes(std::size_t size) {
    if (size > rest_.size()) {
      throw InputError(fmt::format("{}: the message is truncated: {} bytes are left, expected {}",
                                   *where_, rest_.size(), size));
    }
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }
  template <typename Number>
  Number number() {
    Number value;
    std::memcpy(&value, bytes(sizeof(Number)).data(), sizeof(Number));
    return value;
  }
  std::string_view text() { return bytes(number<std::uint32_t>()); }
  double finite(const char* field) {
    const auto value = number<double>();
    if (std::isfinite(value)) return value;
    throw InputError(fmt::format("{}: {} is {}, expected finite numbers", *where_, field, value));
  }
  Eigen::Vector3d vector(const char* field) {
    const double x = finite(field), y = finite(field), z = finite(field);
    return {x, y, z};
  }
  Time header() {
    bytes(4);
    const auto seconds = number<std::uint32_t>();
    const auto nanoseconds = number<std::uint32_t>();
    text();
    return std::chrono::seconds(seconds) + std::chrono::nanoseconds(nanoseconds);
  }

 private:
  std::string_view rest_;
  const std::string* where_;
};

// Grey of ITU-R BT.601, as in every image library.
std::uint8_t grey_of(std::uint32_t red, std::uint32_t green, std::uint32_t blue) {
  return static_cast<std::uint8_t>((299 * red + 587 * green + 114 * blue + 500) / 1000);
}

int channels_of(std::string_view encoding, const std::string& where) {
  if (encoding == "mono8" || encoding == "8UC1") return 1;
  if (encoding == "bgr8" || encoding == "rgb8") return 3;
  throw InputError(
      fmt::format("{}: the encoding is '{:.30}', expected mono8, bgr8 or rgb8 (8 bits "
                  "a channel): convert the bag",
                  where, encoding));
}

}  // namespace

Time ros_stamp(std::string_view message, const std::string& where) {
  return Fields(message, where).header();
}

ImuSample ros_imu(std::string_view message, const std::string& where) {
  Fields fields(message, where);
  ImuSample sample{.time = fields.header()};
  fields.bytes((4 + 9) * sizeof(double));
  sample.angular_rate_imu = fields.vector("angular_velocity");
  fields.bytes(9 * sizeof(double));
  sample.specific_force_imu = fields.vector("linear_acceleration");
  fields.bytes(9 * sizeof(double));
  return sample;
}

GrayImage ros_image(std::string_view message, const ImageSize& expected, const std::string& where) {
  Fields fields(message, where);
  fields.header();
  const auto height = fields.number<std::uint32_t>(), width = fields.number<std::uint32_t>();
  const std::string_view encoding = fields.text();
  const auto channels = static_cast<std::size_t>(channels_of(encoding, where));
  fields.bytes(1);
  const std::size_t step = fields.number<std::uint32_t>();
  const std::string_view data = fields.text();
  if (std::cmp_not_equal(width, expected.width) || std::cmp_not_equal(height, expected.height)) {
    throw InputError(fmt::format("{}: is {} x {} pixels, expected {} x {} as in the calibration",
                                 where, width, height, expected.width, expected.height));
  }
  if (step < width * channels || data.size() != step * height) {
    throw InputError(fmt::format("{}: holds {} bytes in rows of {}, expected {} rows of {} or more",
                                 where, data.size(), step, height, width * channels));
  }
  GrayImage image{.width = expected.width, .height = expected.height, .pixels = {}};
  image.pixels.reserve(std::size_t{width} * height);
  const std::size_t red = encoding == "rgb8" ? 0 : 2;
  for (std::size_t v = 0; v < height; ++v) {
    for (std::size_t at = v * step; at < v * step + width * channels; at += channels) {
      image.pixels.push_back(channels == 1 ? static_cast<std::uint8_t>(byte_at(data, at))
                                           : grey_of(byte_at(data, at + red), byte_at(data, at + 1),
                                                     byte_at(data, at + 2 - red)));
    }
  }
  return image;
}

GrayImage ros_compressed_image(std::string_view message, const ImageSize& expected,
                               const std::string& where) {
  Fields fields(message, where);
  fields.header();
  fields.text();
  return decode_image(fields.text(), expected, where);
}

}  // namespace chasles
