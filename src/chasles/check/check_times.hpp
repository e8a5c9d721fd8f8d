#pragma once

#include <string>
#include <vector>

#include <chasles/check/check_report.hpp>
#include <chasles/time.hpp>

namespace chasles {

/// How regular a stream of stamps is.
struct TimesCheck {
  std::size_t count = 0;
  double interval = 0;       ///< the median one [s]
  double jitter = 0;         ///< nine in ten intervals are within this of the median [s]
  double longest = 0;        ///< [s]
  double longest_after = 0;  ///< where it begins, from the first stamp on [s]
  std::size_t gaps = 0;      ///< intervals longer than 1.5 times the median
  std::size_t missing = 0;   ///< stamps that would have filled them
  std::size_t late = 0;      ///< stamps before an earlier one
  std::size_t repeated = 0;  ///< stamps equal to the one before
};

/// Of stamps in the order in which they came; fewer than two have no intervals.
TimesCheck check_times(const std::vector<Time>& stamps);

/// From where on an interval is too long whatever the rate [s].
struct TimesLimits {
  double interval = 0;
};

/// Adds facts and findings about a stream, named `about`.
void report_times(const TimesCheck& times, const TimesLimits& limits, const std::string& about,
                  CheckReport& report);

}  // namespace chasles
