#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

/// Shared by the readers of binary files.
namespace chasles {

/// Byte i as a number, 0 to 255. Presumes i < bytes.size().
inline std::uint32_t byte_at(std::string_view bytes, std::size_t i) {
  return static_cast<unsigned char>(bytes[i]);
}

/// Deflate compresses by at most 1032 : 1. A file that claims more is damaged.
inline constexpr std::size_t kMostInflation = 1040;

/// The largest number of values in one field of a file; readers reject more.
inline constexpr std::size_t kLargestField = 10'000'000;

}  // namespace chasles
