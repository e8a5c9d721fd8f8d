#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/imu/imu_sample.hpp>
#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// Gravity and accelerometer bias, estimated from a known trajectory and IMU samples.
struct GravityFit {
  Eigen::Vector3d gravity_world = Eigen::Vector3d::Zero();       ///< [m/s^2], points down
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  ///< mean bias [m/s^2]
  int windows = 0;                                               ///< number of windows used
  double left = 0;  ///< root mean square of what is left of a window's difference of slopes [m/s]
};

/// Fits gravity and a constant accelerometer bias. A window has three poses at t0 < t1 < t2, about
/// a second apart. With the hat function h (0, 1, 0 at these times), integration by parts gives
/// exactly
///   (p2 - p1)/(t2 - t1) - (p1 - p0)/(t1 - t0) = integral of h (R (f - b) + g),
/// which is linear in b and g and needs no velocity. R is interpolated between poses. Windows with
/// a gap of poses (0.2 s) or samples (0.05 s) are left out. A bias that the rotations do not make
/// observable stays near zero (prior: 0.3 m/s^2). Returns nothing for fewer than three windows.
std::optional<GravityFit> fit_gravity(const Trajectory& world_T_imu,
                                      const std::vector<ImuSample>& imu);

}  // namespace chasles
