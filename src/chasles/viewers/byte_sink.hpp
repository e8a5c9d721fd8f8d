#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

namespace chasles {

/// Appends the little-endian bytes of a number, whatever the machine's own order.
template <typename Number>
void append_little_endian(std::string& bytes, Number number) {
  static_assert(std::is_arithmetic_v<Number>);
  using Bits = std::conditional_t<
      sizeof(Number) == 8, std::uint64_t,
      std::conditional_t<sizeof(Number) == 4, std::uint32_t,
                         std::conditional_t<sizeof(Number) == 2, std::uint16_t, std::uint8_t>>>;
  const auto bits = std::bit_cast<Bits>(number);
  for (unsigned k = 0; k < sizeof(Number); ++k) {
    bytes.push_back(static_cast<char>(static_cast<std::uint64_t>(bits) >> (8 * k) & 0xff));
  }
}

}  // namespace chasles
