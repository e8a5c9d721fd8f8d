#pragma once

#include <chasles/recording/recording.hpp>

namespace chasles {

/// world_T_imu at every frame, integrated from the velocities only (midpoint rule, exact
/// exponential). The pose at the first event is the identity. Ends at the first pose that is not
/// finite.
Trajectory dead_reckoning(const Recording& recording);

}  // namespace chasles
