#pragma once

#include <chasles/data/run.hpp>

namespace chasles {

/// Places the run's world on the truth's by the best fit, of position and yaw where gravity tells
/// what is vertical (is_level()), else rigid, as the page's overview does. Throws InputError where
/// estimate and truth are not comparable.
SE3 truth_T_world(const Run& run);

/// world_T_imu of the states whose poses are finite.
Trajectory finite_poses(const Run& run);

}  // namespace chasles
