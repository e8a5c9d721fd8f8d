#pragma once

#include <chasles/run_folder/run.hpp>

namespace chasles {

/// Aligns the run's world with the truth's by the best fit: of position and yaw if the run
/// is_level(), else rigid, as the page's overview does. Throws InputError if estimate and truth
/// cannot be compared.
SE3 truth_T_world(const Run& run);

/// world_T_imu of the states whose poses are finite.
Trajectory finite_poses(const Run& run);

}  // namespace chasles
