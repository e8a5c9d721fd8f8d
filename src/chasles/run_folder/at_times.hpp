#pragma once

#include <span>
#include <vector>

#include <chasles/lie/trajectory.hpp>
#include <chasles/run_folder/run.hpp>

namespace chasles {

/// A row of a path at another time.
template <typename Row>
struct RowAt {
  Row row;  ///< where it is not known, the nearest row of the path, at the time asked for
  bool known = false;  ///< false outside the path, in gaps, and where the run was lost
};

/// The states at these times, which may be in any order. At the time of a state it is that state;
/// else between its neighbours, if these are at most `longest_gap` apart: the position on a
/// straight line, the rotation on the geodesic, other states in proportion. Covariances and squares
/// of sigmas are in proportion as well: those of the interpolated state are at most that, whatever
/// the correlation of its neighbours. The error of the interpolation itself is not in them.
/// Figures of the frame, such as nis, are 0. Empty for a run without states.
std::vector<RowAt<RunState>> states_at(const Run& run, std::span<const Time> times,
                                       Time longest_gap = kLongestTruthGap);

/// The same of the smoothed path. Empty for a run without one.
std::vector<RowAt<SmoothedPose>> smoothed_at(const Run& run, std::span<const Time> times,
                                             Time longest_gap = kLongestTruthGap);

}  // namespace chasles
