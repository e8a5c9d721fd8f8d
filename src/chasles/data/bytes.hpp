#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

/// What the readers of binary files share.
namespace chasles {

/// A byte as a number, 0 to 255; there must be so many.
inline std::uint32_t byte_at(std::string_view bytes, std::size_t i) {
  return static_cast<unsigned char>(bytes[i]);
}

/// Deflate cannot shrink by more than 1032 : 1, so that a file that claims more is lying.
inline constexpr std::size_t kMostInflation = 1040;

/// More numbers than this in one field of a file are refused.
inline constexpr std::size_t kLargestField = 10'000'000;

}  // namespace chasles
