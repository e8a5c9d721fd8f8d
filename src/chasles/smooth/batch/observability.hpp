#pragma once

#include <string>
#include <vector>

#include <chasles/imu/strapdown.hpp>

namespace chasles {

/// What the data say of the state at the start, [rotation, position, velocity, accelerometer bias,
/// gyroscope bias] in the reference chart: the difference of the information with them and of the
/// prior alone. Position and heading, which no sensor tells, are left out. Every direction that is
/// told to less than 0.1 rad, 1 m/s, 1 m/s^2 or 0.1 rad/s is named by its parts, the largest first:
/// "velocity y with accelerometer bias y, roll". Both covariances must be positive definite.
std::vector<std::string> unobservable_directions(const Matrix15d& posterior,
                                                 const Matrix15d& prior);

}  // namespace chasles
