#pragma once

#include <string>
#include <vector>

#include <chasles/recording/recording.hpp>

namespace chasles {

// Clocks and units of times that do not fit together: the same checks for every reader. Each throws
// InputError, starting with `where`, with what was found and a guess of the cause.

/// Throws if more than half of the times are those of others, as stamps that were never set or were
/// rounded (to seconds, or to a 32-bit number) are. `what` names the rows: "IMU samples".
void check_distinct(const std::string& where, const std::string& what, std::vector<Time> times);

/// Throws for rates that no sensor has (IMU samples or velocities above 20 kHz, frames above
/// 2 kHz), and if no frame lies within the IMU samples or velocities. Both spans of time and a
/// guess of the clocks are in the message: since boot or since 1970, microseconds, a time zone.
void check_time_spans(const std::string& where, const Recording& recording);

/// The times of one sensor, and what messages call its rows: "gyroscope samples of gyro.csv".
struct NamedTimes {
  std::string what;
  std::vector<Time> times;  ///< in order, at least one
};

/// Throws if the two have no time in common, with a guess of the clocks as check_time_spans().
void check_overlap(const std::string& where, const NamedTimes& a, const NamedTimes& b);

}  // namespace chasles
