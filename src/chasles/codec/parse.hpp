#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <chasles/base/time.hpp>

namespace chasles {

// Each function parses the whole text or throws InputError. The message starts with `where` and
// includes the text found.

/// A number, finite or not ("nan", "inf").
double parse_number(const std::string& where, std::string_view text);

/// A finite number.
double parse_finite(const std::string& where, std::string_view text);

/// An integer.
std::int64_t parse_integer(const std::string& where, std::string_view text);

/// The largest absolute time that is read, since 1970 (the year 2115) [s]. The sum and difference
/// of any two times then also fit into integer nanoseconds.
inline constexpr std::int64_t kLastSecond = 4'600'000'000;
inline constexpr std::int64_t kLastNanosecond = kLastSecond * 1'000'000'000;

/// A time in whole nanoseconds.
Time parse_nanoseconds(const std::string& where, std::string_view text);

/// A time in seconds, exact to the nanosecond for plain decimals. A double would lose 0.2 µs of a
/// present-day stamp.
Time parse_seconds(const std::string& where, std::string_view text);

/// The seconds with nine decimals; parse_seconds() returns the same time.
std::string seconds_text(Time time);

}  // namespace chasles
