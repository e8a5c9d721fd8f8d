#pragma once

#include <Eigen/Core>

#include <chasles/estimate/estimate.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

/// The motion of the IMU that a body's state follows from.
struct ImuMotion {
  SE3 world_T_imu;
  Eigen::Vector3d v_world = Eigen::Vector3d::Zero();  ///< [m/s]
  /// As measured, less the estimated bias [rad/s].
  Eigen::Vector3d angular_rate_imu = Eigen::Vector3d::Zero();
  /// Of the errors [theta; dp; dv; accelerometer bias; gyroscope bias] of an Estimate: 15 x 15.
  MotionCovariance covariance = MotionCovariance::Zero(15, 15);
  double rate_variance = 0;  ///< of the white noise of angular_rate_imu, each axis [rad^2/s^2]
};

/// The state of a body as nav_msgs/Odometry has it.
struct BodyState {
  SE3 world_T_body;
  /// Of [position; rotation], both in world axes: R = Exp(theta) R_hat, p = p_hat + dp. The order
  /// of geometry_msgs/PoseWithCovariance, whose rotations are about fixed axes.
  Matrix6d pose_covariance = Matrix6d::Zero();
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< of the body's origin, body axes [m/s]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< body axes [rad/s]
  Matrix6d twist_covariance = Matrix6d::Zero();       ///< of [linear; angular]
};

/// The state of a body that holds the IMU, to first order in the errors.
BodyState body_state(const ImuMotion& motion, const SE3& body_T_imu);

/// Covariance of [position; rotation] from that of [rotation; position], and the reverse.
Matrix6d position_first(const Matrix6d& rotation_first);

}  // namespace chasles
