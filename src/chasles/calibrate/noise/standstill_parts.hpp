#pragma once

#include <span>
#include <vector>

#include <chasles/calibrate/noise/even_samples.hpp>

namespace chasles {

inline constexpr double kShortestStandstill = 3;  ///< of a part [s]

/// Which samples of each span are of a standstill, and which are left to the motion.
struct StandstillParts {
  std::vector<EvenSpan> standstill, motion;
  double longest = 0;  ///< of the standstills found, also of those that are too short [s]
};

/// Standstills of at least three seconds. They are the standstills of
/// find_standstills() (check/check_imu.hpp) in means of at most 200 a second, less half a second at
/// an end where a motion is, and less half seconds that scatter by more than three times the
/// median: somebody touched the sensor.
StandstillParts find_standstill_parts(std::span<const EvenSpan> spans);

}  // namespace chasles
