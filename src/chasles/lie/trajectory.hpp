#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include <chasles/base/time.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

/// A pose at a time. The user of the struct defines the frames (usually world_T_imu).
struct StampedPose {
  Time time{};
  SE3 pose;
};

/// Poses in order of time.
using Trajectory = std::vector<StampedPose>;

/// The longest gap between two true poses that is interpolated by default. A body that accelerates
/// by a moves at most a t^2/8 off the straight line: 5 mm for 1 m/s^2.
inline constexpr Time kLongestTruthGap = std::chrono::milliseconds(200);
inline constexpr double kMostTruthGap = 3600;  ///< the longest gap that can be set [s]

/// The pose at that time: that of the stamp, bit by bit, or between the two neighbours if they are
/// at most `longest_gap` apart: the position on a straight line, the rotation on the geodesic
/// (SLERP). Elsewhere that of a stamp within 0.1 ms, for stamps that were rounded; else none.
/// O(log n).
std::optional<SE3> pose_at(const Trajectory& trajectory, Time time,
                           Time longest_gap = kLongestTruthGap);

}  // namespace chasles
