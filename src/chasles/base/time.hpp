#pragma once

#include <chrono>

namespace chasles {

/// A time stamp or a duration: integer nanoseconds, so that equal stamps compare equal.
using Time = std::chrono::nanoseconds;

/// Seconds as a floating-point number, for arithmetic on durations. The resolution of a present-day
/// stamp is only about 0.2 µs: subtract first, convert afterwards.
inline double to_seconds(Time time) { return std::chrono::duration<double>(time).count(); }

/// A number of seconds, rounded to the nearest nanosecond.
inline Time from_seconds(double seconds) {
  const auto whole = static_cast<double>(static_cast<long long>(seconds));
  const auto fraction =
      static_cast<long long>((seconds - whole) * 1e9 + (seconds < 0 ? -0.5 : 0.5));
  return Time(static_cast<long long>(whole) * 1'000'000'000LL + fraction);
}

}  // namespace chasles
