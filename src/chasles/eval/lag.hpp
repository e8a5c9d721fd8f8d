#pragma once

#include <vector>

#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// The quantity whose course over time is compared. Both are independent of the worlds and of the
/// axes on the body.
enum class SpeedKind { kTurning, kMoving };

/// Of several shifts that fit alike: those nearer than the first are one, and one nearer to zero
/// than the second is taken [s].
inline constexpr double kSameShift = 0.05, kNearShift = 0.6;

/// The shift of the truth's clock at which its speed follows the reference's.
struct Lag {
  double offset = 0;       ///< truth's time + offset = reference's time, to half a step [s]
  double correlation = 0;  ///< Pearson's, of the speeds
  double step = 0;         ///< [s]
};

/// Looks through all shifts at which at least half of the shorter trajectory, and 4 s, overlap. A
/// body that walks turns alike again after half a step, so several shifts may fit: returns the
/// peaks with a correlation of 0.5 or more that are within 0.2 of the highest, that one first, at
/// most 6; and the shift zero, if the two overlap there. `biased`: both mean rates are removed
/// before. O(n^2) with at most 6000 steps.
std::vector<Lag> find_lags(const Trajectory& reference, const Trajectory& truth, SpeedKind kind,
                           bool biased = false, Time gap = kLongestTruthGap);

}  // namespace chasles
