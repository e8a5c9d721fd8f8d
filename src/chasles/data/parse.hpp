#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <chasles/time.hpp>

namespace chasles {

// Each takes the whole text or throws InputError, which begins with `where` and tells what was
// found.

/// A number, finite or not ("nan", "inf").
double parse_number(const std::string& where, std::string_view text);

/// A finite number.
double parse_finite(const std::string& where, std::string_view text);

/// An integer.
std::int64_t parse_integer(const std::string& where, std::string_view text);

/// Times are read up to so far from 1970 (the year 2115): the difference of any two, and their sum,
/// then are integer nanoseconds too [s].
inline constexpr std::int64_t kLastSecond = 4'600'000'000;
inline constexpr std::int64_t kLastNanosecond = kLastSecond * 1'000'000'000;

/// A time in whole nanoseconds.
Time parse_nanoseconds(const std::string& where, std::string_view text);

/// A time in seconds, exact to the nanosecond where it is written as plain decimals: a double would
/// lose 0.2 µs of a stamp of today.
Time parse_seconds(const std::string& where, std::string_view text);

/// The seconds with nine decimals: parse_seconds gives the same time back.
std::string seconds_text(Time time);

}  // namespace chasles
