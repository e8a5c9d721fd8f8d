#pragma once

#include <span>

#include <chasles/camera/rolling_shutter.hpp>
#include <chasles/imu/strapdown.hpp>

namespace chasles {

/// What an IMU measures while a sensor is read out, with the biases subtracted: its motion without
/// gravity and without the velocity at the time of the image.
struct MeasuredReadout {
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();         ///< as in ReadoutMotion
  Eigen::Vector3d rate_change = Eigen::Vector3d::Zero();  ///< as in ReadoutMotion
  Eigen::Vector3d force = Eigen::Vector3d::Zero();        ///< mean specific force [m/s^2]

  /// From the IMU's axes at a later time [s] to those at the time of the image.
  Eigen::Matrix3d rotation_after(double seconds) const;
  /// `world_R_imu`, `v_world` [m/s]: at the time of the image.
  ReadoutMotion motion(const Eigen::Matrix3d& world_R_imu, const Eigen::Vector3d& v_world,
                       const Eigen::Vector3d& gravity_world) const;
};

/// From the intervals since the time of the image. The rotation is exact in their middle and at
/// their end. No motion without intervals. `biases`: accelerometer [m/s^2], gyroscope [rad/s].
MeasuredReadout measured_readout(std::span<const ImuInterval> intervals, const Vector6d& biases);

/// The longest readout of the cameras [s].
double longest_readout(std::span<const Camera> cameras);

}  // namespace chasles
