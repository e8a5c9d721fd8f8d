#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

// Writes payloads of GoPro's telemetry, after https://github.com/gopro/gpmf-parser#readme, for the
// tests of their reader.
namespace chasles::test {

inline std::string big_endian_bytes(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(value >> (8 * i) & 255);
  return text;
}

/// Key, type, size of a sample, number of samples, and their bytes padded to a multiple of four.
inline std::string klv(const std::string& key, char type, std::size_t size, std::size_t repeat,
                       const std::string& data) {
  std::string text = key + type + big_endian_bytes(size, 1) + big_endian_bytes(repeat, 2) + data;
  text.resize((text.size() + 3) / 4 * 4, '\0');
  return text;
}
/// Items within an item.
inline std::string nest(const std::string& key, const std::string& items) {
  return klv(key, '\0', 4, items.size() / 4, items);
}
inline std::string klv_text(const std::string& key, const std::string& text) {
  return klv(key, 'c', text.size(), 1, text);
}
inline std::string klv_count(const std::string& key, std::uint32_t value) {
  return klv(key, 'L', 4, 1, big_endian_bytes(value, 4));
}
inline std::string klv_stamp(const std::string& key, std::uint64_t value) {
  return klv(key, 'J', 8, 1, big_endian_bytes(value, 8));
}
inline std::string klv_float(const std::string& key, float value) {
  return klv(key, 'f', 4, 1, big_endian_bytes(std::bit_cast<std::uint32_t>(value), 4));
}
inline std::string klv_shorts(const std::string& key, const std::vector<std::vector<int>>& rows) {
  std::string data;
  for (const std::vector<int>& row : rows) {
    for (const int value : row) {
      data += big_endian_bytes(static_cast<std::uint16_t>(static_cast<std::int16_t>(value)), 2);
    }
  }
  return klv(key, 's', rows.empty() ? 6 : 2 * rows[0].size(), rows.size(), data);
}
/// A 3 x 3 matrix, row by row.
inline std::string klv_matrix(const std::string& key, const std::vector<float>& values) {
  std::string data;
  for (const float value : values) {
    data += big_endian_bytes(std::bit_cast<std::uint32_t>(value), 4);
  }
  return klv(key, 'f', 4 * values.size(), 1, data);
}

}  // namespace chasles::test
