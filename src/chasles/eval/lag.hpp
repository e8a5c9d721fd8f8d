#pragma once

#include <optional>

#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// The quantity whose course over time is compared. Both are independent of the worlds and of the
/// axes on the body.
enum class SpeedKind { kTurning, kMoving };

/// The shift of the truth's clock at which its speed follows the reference's.
struct Lag {
  double offset = 0;       ///< truth's time + offset = reference's time, to half a step [s]
  double correlation = 0;  ///< Pearson's, of the speeds
  double step = 0;         ///< [s]
};

/// Looks through all shifts at which at least half of the shorter trajectory, and 4 s, overlap. A
/// shift within half a second of zero is preferred where it correlates nearly as well; another one
/// must stand out from all others and have a correlation of 0.8 or more. `biased`: both mean rates
/// are removed before. Nothing where no shift is clear. O(n^2) with at most 6000 steps.
std::optional<Lag> find_lag(const Trajectory& reference, const Trajectory& truth, SpeedKind kind,
                            bool biased = false, Time gap = kLongestTruthGap);

}  // namespace chasles
