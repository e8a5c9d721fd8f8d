#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/imu/imu_sample.hpp>
#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// What a known trajectory and an IMU together tell of gravity.
struct GravityFit {
  Eigen::Vector3d gravity_world = Eigen::Vector3d::Zero();       ///< [m/s^2], points down
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  ///< the mean one [m/s^2]
  int windows = 0;                                               ///< how many were used
};

/// Fits gravity and a constant accelerometer bias. Over three poses at t0 < t1 < t2, about a second
/// apart, and the hat function h (0, 1, 0 there), integration by parts gives exactly
///   (p2 - p1)/(t2 - t1) - (p1 - p0)/(t1 - t0) = integral of h (R (f - b) + g),
/// linear in b and g, without any velocity. R is interpolated between poses. Windows with a gap of
/// poses (0.2 s) or samples (0.05 s) are left out. A bias that the rotations do not show stays near
/// zero (prior: 0.3 m/s^2). None with fewer than three windows.
std::optional<GravityFit> fit_gravity(const Trajectory& world_T_imu,
                                      const std::vector<ImuSample>& imu);

}  // namespace chasles
