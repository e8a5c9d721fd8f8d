#pragma once

#include <string>
#include <vector>

#include <chasles/imu/strapdown.hpp>

namespace chasles {

/// The unobservable directions of the state at the start, [rotation, position, velocity,
/// accelerometer bias, gyroscope bias] in the reference chart. The data's information is the
/// difference between that of the posterior and that of the prior. Position and heading, which no
/// sensor determines, are excluded. A direction with a sigma above 0.1 rad, 1 m/s, 1 m/s^2 or 0.1
/// rad/s is named by its components, the largest first: "velocity y with accelerometer bias y,
/// roll". Both covariances must be positive definite.
std::vector<std::string> unobservable_directions(const Matrix15d& posterior,
                                                 const Matrix15d& prior);

}  // namespace chasles
