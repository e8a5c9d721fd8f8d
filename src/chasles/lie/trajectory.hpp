#pragma once

#include <vector>

#include <chasles/lie/se3.hpp>
#include <chasles/time.hpp>

namespace chasles {

/// A pose at a time. The user of the struct defines the frames (usually world_T_imu).
struct StampedPose {
  Time time{};
  SE3 pose;
};

/// Poses in order of time.
using Trajectory = std::vector<StampedPose>;

}  // namespace chasles
