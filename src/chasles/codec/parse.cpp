#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/parse.hpp>

namespace chasles {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

template <typename Number>
std::optional<Number> parsed(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  Number value{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

// Digits after the decimal point as nanoseconds, rounded at the tenth digit.
std::optional<std::int64_t> fraction(std::string_view digits) {
  if (digits.find_first_not_of("0123456789") != std::string_view::npos) return std::nullopt;
  std::int64_t value = 0;
  for (std::size_t i = 0; i < 9; ++i)
    value = value * 10 + (i < digits.size() ? digits[i] - '0' : 0);
  return value + (digits.size() > 9 && digits[9] >= '5' ? 1 : 0);
}

}  // namespace

double parse_number(const std::string& where, std::string_view text) {
  if (const auto value = parsed<double>(text)) return *value;
  throw InputError(fmt::format("{}: found '{:.40}', expected a number", where, text));
}

double parse_finite(const std::string& where, std::string_view text) {
  const double value = parse_number(where, text);
  if (std::isfinite(value)) return value;
  throw InputError(fmt::format("{}: found '{}', expected a finite number", where, text));
}

std::int64_t parse_integer(const std::string& where, std::string_view text) {
  if (const auto value = parsed<std::int64_t>(text)) return *value;
  throw InputError(fmt::format("{}: found '{:.40}', expected an integer", where, text));
}

Time parse_nanoseconds(const std::string& where, std::string_view text) {
  const std::int64_t value = parse_integer(where, text);
  if (value > -kLastNanosecond && value < kLastNanosecond) return Time(value);
  throw InputError(
      fmt::format("{}: found '{}', expected nanoseconds below {}", where, text, kLastNanosecond));
}

Time parse_seconds(const std::string& where, std::string_view text) {
  const bool negative = text.starts_with('-');
  const std::string_view unsigned_text = text.substr(negative ? 1 : 0);
  const std::size_t point = std::min(unsigned_text.find('.'), unsigned_text.size());
  const auto whole = parsed<std::int64_t>(unsigned_text.substr(0, point));
  const auto part = fraction(unsigned_text.substr(std::min(point + 1, unsigned_text.size())));
  if (whole && part && *whole >= 0 && *whole < kLastSecond) {
    const std::int64_t nanoseconds = *whole * kSecond + *part;
    return Time(negative ? -nanoseconds : nanoseconds);
  }
  const double seconds = parse_finite(where, text);
  if (std::abs(seconds) < static_cast<double>(kLastSecond)) return from_seconds(seconds);
  throw InputError(
      fmt::format("{}: found '{}', expected seconds below {}", where, text, kLastSecond));
}

std::string seconds_text(Time time) {
  const std::int64_t nanoseconds = time.count();
  const std::int64_t size = std::abs(nanoseconds);
  return fmt::format("{}{}.{:09}", nanoseconds < 0 ? "-" : "", size / kSecond, size % kSecond);
}

}  // namespace chasles
