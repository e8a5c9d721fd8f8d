#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include <chasles/base/error.hpp>
#include <chasles/base/settings.hpp>

namespace chasles {

/// Throws UsageError: "NAME: found FOUND, expected EXPECTED".
[[noreturn]] inline void reject_value(std::string_view name, std::string_view found,
                                      std::string_view expected) {
  std::string message(name);
  message.append(": found ").append(found).append(", expected ").append(expected);
  throw UsageError(message);
}

/// The shortest text that parses to the same number.
inline std::string number_text(double number) {
  const double size = std::abs(number);
  const bool plain = size == 0 || (size >= 1e-4 && size < 1e16);
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number,
                                 plain ? std::chars_format::fixed : std::chars_format::general);
  return {text.data(), end.ptr};
}

// By append: GCC 12 takes "'" + a string for an overlap (its bug 105651).
inline std::string quoted_text(std::string_view text) {
  std::string all("'");
  all.append(text).append("'");
  return all;
}

/// A setting's value in a message: a text or a choice is quoted_text.
template <typename Value>
std::string setting_text(const Value& value) {
  if constexpr (std::is_same_v<Value, std::optional<double>>) {
    return value ? setting_text(*value) : "auto";
  } else if constexpr (std::is_same_v<Value, bool>) {
    return value ? "true" : "false";
  } else if constexpr (std::is_same_v<Value, double>) {
    return number_text(value);
  } else if constexpr (std::is_integral_v<Value>) {
    return std::to_string(value);
  } else if constexpr (std::is_enum_v<Value>) {
    const std::string_view name = name_of(value);
    return name.empty() ? "the value " + std::to_string(static_cast<int>(value))
                        : quoted_text(name);
  } else {
    return quoted_text(value);
  }
}

inline std::string one_of_text(std::span<const std::string_view> names) {
  std::string text = "one of ";
  for (const std::string_view name : names) {
    text.append(name.data() == names.front().data() ? "" : ", ").append(name);
  }
  return text;
}

/// "above 0 and not above 1 [probability]", each with a space before it.
inline std::string range_text(const Limits& limits, std::string_view unit) {
  std::string text;
  if (std::isfinite(limits.low)) {
    text += (limits.above_low ? " above " : " not below ") + number_text(limits.low);
  }
  if (std::isfinite(limits.high)) {
    text += (text.empty() ? "" : " and") + std::string(" not above ") + number_text(limits.high);
  }
  if (!unit.empty() && unit != "1") text.append(" [").append(unit).append("]");
  return text;
}

/// Description of the expected value of a setting of that type. `unit` as in for_each_setting.
template <typename Value>
std::string expected_text(const Limits& limits, std::string_view unit) {
  if constexpr (std::is_same_v<Value, std::optional<double>>) {
    return expected_text<double>(limits, unit) + ", or auto";
  } else if constexpr (std::is_same_v<Value, bool>) {
    return "true or false";
  } else if constexpr (std::is_same_v<Value, double>) {
    return "a finite number" + range_text(limits, unit);
  } else if constexpr (std::is_integral_v<Value>) {
    return "a whole number" + range_text(limits, unit);
  } else if constexpr (std::is_enum_v<Value>) {
    return one_of_text(kChoiceNames<Value>);
  } else {
    return limits.names.empty() ? "a text" : one_of_text(limits.names);
  }
}

/// Whether a setting with these limits may have that value.
template <typename Value>
bool is_allowed(const Value& value, const Limits& limits) {
  if constexpr (std::is_same_v<Value, std::optional<double>>) {
    return !value || limits.contain(*value);
  } else if constexpr (std::is_same_v<Value, bool>) {
    return true;
  } else if constexpr (std::is_arithmetic_v<Value>) {
    return limits.contain(static_cast<double>(value));
  } else if constexpr (std::is_enum_v<Value>) {
    return !name_of(value).empty();
  } else {
    return limits.names.empty() || std::ranges::find(limits.names, value) != limits.names.end();
  }
}

/// Throws UsageError for the first setting that is not within its limits, with `prefix` and its
/// name, its value and the expected one.
template <typename Settings>
void validate_fields(const Settings& settings, std::string_view prefix = "") {
  for_each_setting(settings, [&](const char* name, const auto& value, std::string_view unit,
                                 const char*, const Limits& limits) {
    if (is_allowed(value, limits)) return;
    using Value = std::remove_cvref_t<decltype(value)>;
    reject_value(std::string(prefix) + name, setting_text(value),
                 expected_text<Value>(limits, unit));
  });
}

/// Returns the settings; throws as their validate().
template <typename Settings>
const Settings& validated(const Settings& settings) {
  validate(settings);
  return settings;
}

}  // namespace chasles
