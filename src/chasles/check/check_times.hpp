#pragma once

#include <string>
#include <vector>

#include <chasles/base/time.hpp>
#include <chasles/check/check_report.hpp>

namespace chasles {

/// The regularity of a stream of time stamps.
struct TimesCheck {
  std::size_t count = 0;
  double interval = 0;  ///< median interval; of stamps that are lost at random: of the sensor [s]
  double jitter = 0;    ///< 90 % of the intervals are within this of it, or of a multiple [s]
  bool lossy = false;   ///< the intervals are multiples of one that is shorter than most of them
  double longest = 0;   ///< [s]
  double longest_after = 0;  ///< its start, since the first stamp [s]
  std::size_t gaps = 0;      ///< intervals longer than 1.5 times `interval`
  std::size_t missing = 0;   ///< number of stamps missing in the gaps
  std::size_t late = 0;      ///< stamps before an earlier one
  std::size_t repeated = 0;  ///< stamps equal to the one before
};

/// Statistics of stamps in the order of arrival. Fewer than two stamps have no intervals. Where the
/// intervals scatter about their median, but nine in ten are multiples of it or of a part of it
/// (down to an eighth), frames are lost at random and nothing jitters.
TimesCheck check_times(const std::vector<Time>& stamps);

/// Limits that do not depend on the rate of the stream: the longest acceptable interval [s].
struct TimesLimits {
  double interval = 0;
};

/// Adds facts and findings about a stream, named `about`.
void report_times(const TimesCheck& times, const TimesLimits& limits, const std::string& about,
                  CheckReport& report);

}  // namespace chasles
