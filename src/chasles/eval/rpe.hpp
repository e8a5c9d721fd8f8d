#pragma once

#include <vector>

#include <chasles/eval/ate.hpp>

namespace chasles {

/// The pieces of the trajectory over which the relative errors are measured.
struct RelativeErrorOptions {
  std::vector<double> distances_m = {100, 200, 300, 400, 500, 600, 700, 800};
  std::vector<double> intervals_s = {1, 10};
  /// A piece starts at every step-th matched pose. 10 is the value of the KITTI benchmark and of
  /// published figures; 1 uses all data.
  int step = 10;
};

/// Relative pose errors over pieces of one length.
struct RelativeError {
  double length = 0;       ///< along the truth's path [m], or in time [s]
  Statistics translation;  ///< over a distance: % of it; over a time: m
  Statistics rotation;     ///< over a distance: deg/m; over a time: deg
};

/// KITTI odometry's measure (Geiger et al. 2012): a piece ends at the first pose whose distance
/// along the truth's path exceeds the length; its error is the pose (delta_estimate)^-1 *
/// delta_truth, the norm of its translation and its angle over the length. One entry a length;
/// lengths longer than the path have count 0 and NaN. Independent of any alignment but scale.
/// Throws UsageError for a step below 1 or a length that is not positive.
std::vector<RelativeError> relative_error_over_distance(const MatchedTrajectories& matched,
                                                        const RelativeErrorOptions& options = {});

/// The same over times: a piece ends at the pose nearest to start + interval, and is left out
/// where that pose misses by more than half the median spacing (a gap).
std::vector<RelativeError> relative_error_over_time(const MatchedTrajectories& matched,
                                                    const RelativeErrorOptions& options = {});

}  // namespace chasles
