#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include <chasles/base/time.hpp>

namespace chasles {

/// The serialisation of a message: ROS 1 (little-endian, packed), CDR of ROS 2 (aligned, of either
/// byte order), or one that is not read (JSON, protobuf).
enum class Wire { kRos1, kCdr, kOther };

/// std_msgs/Header.
struct MessageHeader {
  Time stamp{};
  std::string_view frame;
};

/// Takes fields from the front of a message, whatever its serialisation. Every length is compared
/// with the bytes that are left; InputError starts with `where`.
class MessageFields {
 public:
  /// `where` must outlive this.
  MessageFields(std::string_view bytes, Wire wire, const std::string& where);

  template <typename Number>
  Number number() {
    align(sizeof(Number));
    std::array<char, sizeof(Number)> raw;
    std::memcpy(raw.data(), take(sizeof(Number)).data(), sizeof(Number));
    if (swap_) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<Number>(raw);
  }
  template <typename Number>
  void skip(std::size_t count) {
    if (count == 0) return;
    align(sizeof(Number));
    take(count * sizeof(Number));
  }
  std::string_view text();
  std::string_view bytes();  ///< of a sequence uint8[]
  /// The length of a sequence of elements that take `least` bytes or more each.
  std::size_t count(std::size_t least);
  Eigen::Vector3d vector();
  MessageHeader header();

 private:
  std::string_view take(std::size_t size);
  void align(std::size_t size);

  std::string_view rest_;
  Wire wire_;
  bool swap_ = false;
  std::size_t taken_ = 0;  // since the start of what alignment refers to
  const std::string* where_;
};

}  // namespace chasles
