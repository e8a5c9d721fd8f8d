#pragma once

#include <optional>

#include <chasles/filter/calibration.hpp>
#include <chasles/imu/strapdown.hpp>
#include <chasles/slam/inertial_settings.hpp>
#include <chasles/time.hpp>

namespace chasles {

/// Where an inertial run begins, in nav.
struct InertialStart {
  Time time{};  ///< of the IMU's clock
  SE3 nav_T_imu;
  Eigen::Vector3d v_nav = Eigen::Vector3d::Zero();               ///< [m/s]
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  ///< [m/s^2]
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();      ///< [rad/s]
  /// Of the errors [rotation, position, velocity, accelerometer bias, gyroscope bias], standard
  /// error, nav's axes; none: the initial deviations of the settings. Position and heading are
  /// where nav begins: their rows are 0.
  std::optional<Matrix15d> covariance = {};
  /// What has been learnt of what the settings say is estimated of the sensors' arrangement; none:
  /// the recording's and the settings' own.
  std::optional<Calibration> calibration = {};
};

/// The start's own covariance, or the initial deviations of the settings: roll and pitch are errors
/// about nav's horizontal axes.
Matrix15d start_covariance(const InertialSlamSettings& settings, const InertialStart& start);

}  // namespace chasles
