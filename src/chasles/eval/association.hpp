#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <chasles/lie/truth_pairing.hpp>

namespace chasles {

/// An estimate and the truth at the same instants: two trajectories of equal size. Row i of one
/// corresponds to row i of the other.
struct MatchedTrajectories {
  Trajectory estimate;                      ///< world_T_imu, in the estimate's world
  Trajectory truth;                         ///< world_T_imu, in the truth's world
  std::vector<std::size_t> estimate_index;  ///< index of row i in the whole estimate
  std::size_t interpolated = 0;             ///< rows whose truth lies between two of its stamps
};

/// The median difference of consecutive stamps; zero for fewer than two poses.
Time median_spacing(const Trajectory& trajectory);

/// Pairs each pose of the estimate with the truth at its time, as pose_at(); poses without a truth
/// stay alone. With Pairing::kNearest it pairs the poses that are nearest in time to each other:
/// each is the other's nearest, so none is used twice. O(n log n).
///
/// Throws InputError for stamps that do not increase, for a pose that is not finite, and for fewer
/// than three pairs.
MatchedTrajectories associate(const Trajectory& estimate, const Trajectory& truth,
                              const TruthPairing& pairing = {});

/// Length of the path through the positions [m].
double path_length(const Trajectory& trajectory);

/// Length of the path from the first pose to each pose [m].
std::vector<double> distances_along(const Trajectory& trajectory);

}  // namespace chasles
