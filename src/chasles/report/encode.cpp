#include <bit>

#include <nlohmann/json.hpp>

#include <chasles/report/encode.hpp>

namespace chasles {
namespace {

template <typename Bits>
void append_little_endian(std::vector<std::uint8_t>& bytes, Bits bits) {
  for (unsigned shift = 0; shift < 8 * sizeof(Bits); shift += 8) {
    bytes.push_back(static_cast<std::uint8_t>(bits >> shift));
  }
}

}  // namespace

std::string base64(const std::vector<std::uint8_t>& bytes) {
  static constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const std::uint32_t group = (std::uint32_t{bytes[i]} << 16) |
                                (left > 1 ? std::uint32_t{bytes[i + 1]} << 8 : 0) |
                                (left > 2 ? std::uint32_t{bytes[i + 2]} : 0);
    text += kDigits[group >> 18];
    text += kDigits[(group >> 12) & 63];
    text += left > 1 ? kDigits[(group >> 6) & 63] : '=';
    text += left > 2 ? kDigits[group & 63] : '=';
  }
  return text;
}

std::string float_column(const std::vector<double>& values) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(values.size() * sizeof(float));
  for (const double value : values) {
    append_little_endian(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
  }
  return "f32:" + base64(bytes);
}

std::string double_column(const std::vector<double>& values) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(values.size() * sizeof(double));
  for (const double value : values) {
    append_little_endian(bytes, std::bit_cast<std::uint64_t>(value));
  }
  return "f64:" + base64(bytes);
}

std::string int_column(const std::vector<int>& values) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(values.size() * sizeof(std::int32_t));
  for (const int value : values) append_little_endian(bytes, static_cast<std::uint32_t>(value));
  return "i32:" + base64(bytes);
}

std::string json_for_html(const nlohmann::ordered_json& json) {
  const std::string text =
      json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    // Outside of strings json has none of these, inside of strings the escape means the same.
    if (c == '<')
      safe += "\\u003c";
    else if (c == '>')
      safe += "\\u003e";
    else if (c == '&')
      safe += "\\u0026";
    else
      safe += c;
  }
  return safe;
}

}  // namespace chasles
