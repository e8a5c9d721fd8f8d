#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/imu/imu_sample.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

/// The attitude of a camera against a target at an instant of the camera's clock.
struct SeenAttitude {
  Time time{};
  Eigen::Matrix3d cam_R_target;
};

/// How a camera is mounted on an IMU, from rotations alone.
struct RotationAlignment {
  Eigen::Matrix3d cam_R_imu;
  double time_offset = 0;          ///< camera clock + offset = IMU clock [s]
  Eigen::Vector3d gyroscope_bias;  ///< [rad/s]
  double unexplained = 0;          ///< part of the squares of the rates that is left, 0 to 1
};

/// Compares the turns between successive attitudes with the gyroscope, for each offset up to `most`
/// [s] (Kabsch's rotation of the mean-free rates; the least residual). From nothing. None with
/// fewer than 10 turns.
std::optional<RotationAlignment> align_rotations(const std::vector<SeenAttitude>& attitudes,
                                                 const std::vector<ImuSample>& imu,
                                                 double most = 1);

}  // namespace chasles
