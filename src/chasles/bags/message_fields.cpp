#include <fmt/format.h>

#include <chasles/bags/message_fields.hpp>
#include <chasles/base/error.hpp>
#include <chasles/codec/bytes.hpp>

namespace chasles {

static_assert(std::endian::native == std::endian::little);

// CDR begins with four bytes: 0, then 0 (big-endian) or 1 (little-endian), and options.
MessageFields::MessageFields(std::string_view bytes, Wire wire, const std::string& where)
    : rest_(bytes), wire_(wire), where_(&where) {
  if (wire != Wire::kCdr) return;
  const std::string_view begin = take(4);
  if (byte_at(begin, 0) != 0 || byte_at(begin, 1) > 1) {
    throw InputError(
        fmt::format("{}: begins with the bytes {:02x} {:02x}, expected CDR (00 00 or "
                    "00 01)",
                    where, byte_at(begin, 0), byte_at(begin, 1)));
  }
  swap_ = byte_at(begin, 1) == 0;
  taken_ = 0;
}

std::string_view MessageFields::take(std::size_t size) {
  if (size > rest_.size()) {
    throw InputError(fmt::format("{}: the message is truncated: {} bytes are left, expected {}",
                                 *where_, rest_.size(), size));
  }
  const std::string_view taken = rest_.substr(0, size);
  rest_.remove_prefix(size);
  taken_ += size;
  return taken;
}

void MessageFields::align(std::size_t size) {
  if (wire_ == Wire::kCdr) take((size - taken_ % size) % size);
}

std::string_view MessageFields::text() {
  std::string_view text = bytes();
  if (wire_ == Wire::kCdr && text.ends_with('\0')) text.remove_suffix(1);
  return text;
}

std::string_view MessageFields::bytes() { return take(number<std::uint32_t>()); }

std::size_t MessageFields::count(std::size_t least) {
  const std::size_t count = number<std::uint32_t>();
  if (count <= rest_.size() / least) return count;
  throw InputError(
      fmt::format("{}: the message is truncated: {} bytes are left, expected {} "
                  "elements",
                  *where_, rest_.size(), count));
}

Eigen::Vector3d MessageFields::vector() {
  const auto x = number<double>(), y = number<double>(), z = number<double>();
  return {x, y, z};
}

MessageHeader MessageFields::header() {
  if (wire_ == Wire::kRos1) number<std::uint32_t>();  // seq
  // ROS 2 has signed seconds; both are positive until 2038.
  const std::int64_t seconds = wire_ == Wire::kRos1 ? std::int64_t{number<std::uint32_t>()}
                                                    : std::int64_t{number<std::int32_t>()};
  const auto nanoseconds = number<std::uint32_t>();
  return {.stamp = std::chrono::seconds(seconds) + std::chrono::nanoseconds(nanoseconds),
          .frame = text()};
}

}  // namespace chasles
