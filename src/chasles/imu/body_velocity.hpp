#pragma once

#include <Eigen/Core>

#include <chasles/base/time.hpp>

namespace chasles {

/// The velocity of the IMU frame relative to the world, in the axes of the IMU frame (x forward, y
/// left, z up on a car), at one instant, as measured by wheels, GNSS/INS or an odometer (Du, eq. 6:
/// u = [v, w]). Some sources use level axes instead (level_axes.hpp).
struct BodyVelocity {
  Time time{};
  Eigen::Vector3d linear_imu = Eigen::Vector3d::Zero();   ///< [m/s]
  Eigen::Vector3d angular_imu = Eigen::Vector3d::Zero();  ///< [rad/s]
};

/// Standard deviations of a sample's white noise, axis by axis.
struct BodyVelocitySigma {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< [m/s]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< [rad/s]
};

}  // namespace chasles
