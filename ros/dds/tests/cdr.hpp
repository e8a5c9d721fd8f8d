#pragma once

#include <array>
#include <cstdint>
#include <string>

#include <Eigen/Core>

#include <chasles/bags/message_fields.hpp>
#include <chasles/imu/imu_sample.hpp>

// Messages of ROS 2 as bytes, written by hand: the tests must not rely on the bridge's IDL.
namespace chasles::test {

/// Plain CDR, little-endian, with its encapsulation.
class CdrWriter {
 public:
  template <typename Number>
  CdrWriter& number(Number value) {
    while ((bytes_.size() - kEncapsulation) % sizeof(Number) != 0) bytes_ += '\0';
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(Number));
    return *this;
  }
  CdrWriter& numbers(const Eigen::VectorXd& values) {
    for (const double value : values) number(value);
    return *this;
  }
  CdrWriter& text(const std::string& value) {
    number(static_cast<std::uint32_t>(value.size() + 1));
    bytes_.append(value.c_str(), value.size() + 1);
    return *this;
  }
  CdrWriter& octets(std::string_view value) {
    number(static_cast<std::uint32_t>(value.size()));
    bytes_ += value;
    return *this;
  }
  CdrWriter& header(Time stamp, const std::string& frame) {
    number(static_cast<std::int32_t>(stamp.count() / 1'000'000'000));
    number(static_cast<std::uint32_t>(stamp.count() % 1'000'000'000));
    return text(frame);
  }
  std::string bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kEncapsulation = 4;
  std::string bytes_ = std::string("\0\1\0\0", kEncapsulation);
};

inline std::string imu_bytes(const ImuSample& s) {
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(9);
  return CdrWriter()
      .header(s.time, "imu")
      .numbers(Eigen::Vector4d(0, 0, 0, 1))
      .numbers(none)
      .numbers(s.angular_rate_imu)
      .numbers(none)
      .numbers(s.specific_force_imu)
      .numbers(none)
      .bytes();
}

inline std::string image_bytes(Time stamp, std::uint32_t width, std::uint32_t height,
                               const std::string& encoding, std::string_view pixels) {
  return CdrWriter()
      .header(stamp, "cam")
      .number(height)
      .number(width)
      .text(encoding)
      .number(std::uint8_t{0})
      .number(width)
      .octets(pixels)
      .bytes();
}

inline std::string compressed_bytes(Time stamp, const std::string& format, std::string_view file) {
  return CdrWriter().header(stamp, "cam").text(format).octets(file).bytes();
}

}  // namespace chasles::test
