#pragma once

#include <optional>

#include <chasles/base/time.hpp>
#include <chasles/camera/camera.hpp>
#include <chasles/estimate/estimate.hpp>
#include <chasles/filter/calibration.hpp>
#include <chasles/imu/strapdown.hpp>
#include <chasles/initialise/initialiser_settings.hpp>

namespace chasles {

/// The state at which a visual-inertial run starts, in nav.
struct InertialStart {
  Time time{};  ///< on the IMU's clock
  SE3 nav_T_imu;
  Eigen::Vector3d v_nav = Eigen::Vector3d::Zero();               ///< [m/s]
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  ///< [m/s^2]
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();      ///< [rad/s]
  /// Covariance of the errors [rotation, position, velocity, accelerometer bias, gyroscope bias],
  /// standard error, nav axes; none: the initial sigmas of the settings. Position and heading
  /// define nav, so their rows are 0, except for position_sigma and heading_sigma of
  /// InitialiserSettings.
  std::optional<Matrix15d> covariance = {};
  /// The derivative of these errors by those of the IMU's parameters, 15 x their number; empty:
  /// they do not depend on them. The covariance is that for given parameters.
  Eigen::MatrixXd by_imu = {};
  /// Estimate of the calibration that the settings estimate; none: that of the recording and the
  /// settings.
  std::optional<Calibration> calibration = {};
};

/// The start, turned by this angle about the vertical through its position [rad].
InertialStart turned(InertialStart start, double angle);

/// Direction of the camera's line of sight, counter-clockwise from nav's x axis [rad]. Where it
/// looks down by more than 45 degrees: that of the top of its image; where up: of the bottom.
double camera_heading(const Eigen::Matrix3d& nav_R_imu, const Camera& camera);

/// A start at nav's origin, moved to the position of the settings and turned so that this camera
/// has their heading. The covariance gets the errors of both (position_sigma, heading_sigma).
InertialStart placed(InertialStart start, const InitialiserSettings& settings,
                     const Camera& camera);

/// A start in its own nav, moved to the pose of an estimate before it, with a covariance that grows
/// over the time in between, up to a sigma of 500 m.
InertialStart continued(InertialStart start, const Estimate& before);

}  // namespace chasles
