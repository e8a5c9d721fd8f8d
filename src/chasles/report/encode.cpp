#include <bit>
#include <stdexcept>
#include <zlib.h>

#include <nlohmann/json.hpp>

#include <chasles/codec/utf8.hpp>
#include <chasles/report/encode.hpp>

namespace chasles {
namespace {

std::vector<std::uint8_t> deflated(const std::vector<std::uint8_t>& bytes) {
  uLongf size = compressBound(bytes.size());
  std::vector<std::uint8_t> out(size);
  if (compress2(out.data(), &size, bytes.data(), bytes.size(), Z_DEFAULT_COMPRESSION) != Z_OK) {
    throw std::runtime_error("zlib cannot compress");  // only for want of memory
  }
  out.resize(size);
  return out;
}

template <typename Value, typename ToBits>
std::string packed(const std::vector<Value>& values, const ToBits& to_bits) {
  using Bits = decltype(to_bits(values.front()));
  std::vector<std::uint8_t> planes;
  planes.reserve(values.size() * sizeof(Bits));
  for (unsigned shift = 0; shift < 8 * sizeof(Bits); shift += 8) {
    for (const Value value : values) {
      planes.push_back(static_cast<std::uint8_t>(to_bits(value) >> shift));
    }
  }
  return base64(deflated(planes));
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
  return "f32:" + packed(values, [](double value) {
           return std::bit_cast<std::uint32_t>(static_cast<float>(value));
         });
}

std::string double_column(const std::vector<double>& values) {
  return "f64:" + packed(values, [](double value) { return std::bit_cast<std::uint64_t>(value); });
}

std::string int_column(const std::vector<int>& values) {
  return "i32:" + packed(values, [](int value) { return static_cast<std::uint32_t>(value); });
}

std::string json_for_html(const nlohmann::ordered_json& json) {
  const std::string text = json_text(json);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    // Outside strings JSON has none of these; inside strings the escape is equivalent.
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

std::string with_data(std::string_view page, const nlohmann::ordered_json& data) {
  static constexpr std::string_view kPlace = "@PAGE_DATA@";
  const std::size_t place = page.find(kPlace);
  std::string filled(page.substr(0, place));
  filled += json_for_html(data);
  filled += page.substr(place + kPlace.size());
  return filled;
}

}  // namespace chasles
