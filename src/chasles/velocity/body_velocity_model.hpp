#pragma once

#include <Eigen/Core>

#include <chasles/filter/ekf.hpp>
#include <chasles/imu/body_velocity.hpp>

namespace chasles {

/// Noise densities and per-sample standard deviations of the body velocities. Each Vector6d is
/// [angular; linear], in the order of the pose errors.
struct BodyVelocityNoise {
  Vector6d sample_sigma = Vector6d::Zero();  ///< white noise of one sample [rad/s, m/s]
  Vector6d walk = Vector6d::Zero();          ///< random walk of the velocity state [unit/sqrt(s)]
  double gyro_bias_walk = 0;                 ///< [rad/s/sqrt(s)]
  double scale_walk = 0;                     ///< of the velocity's scale [1/sqrt(s)]
  double tilt_walk = 0;                      ///< [rad/sqrt(s)]
  double heading_walk = 0;                   ///< [rad/sqrt(s)]
};

/// Propagation of the pose by body velocities (Du, eq. 6: T+ = T exp(tau u), exact), and the states
/// that the model adds to the core's `additive` part:
///
///   [ velocity 6: angular, linear (imu axes) | gyroscope bias 3 | log of the velocity's scale 1 |
///     tilt 2 | heading 1 ]
///
/// With the velocity in the state, a sample is a noisy measurement of a slowly varying velocity.
/// Without, the sample is the input that is integrated over the step, and its noise enters the
/// pose.
///
/// With `level`, the samples are in level axes (velocity/level_axes.hpp) rotated by `heading`,
/// sample_R_imu = Rz(heading) level_R_imu. The direction of the vertical is estimated too:
/// nav_R_world = Exp([tilt, 0]). Tilt and heading are in rad. Requires a velocity state.
struct BodyVelocityModel {
  bool velocity_state = true;
  bool gyro_bias = true;
  bool scale = false;
  bool level = false;

  constexpr int bias_index() const { return velocity_state ? 6 : 0; }  ///< in State::additive
  constexpr int scale_index() const { return bias_index() + (gyro_bias ? 3 : 0); }
  constexpr int tilt_index() const { return scale_index() + (scale ? 1 : 0); }
  constexpr int heading_index() const { return tilt_index() + 2; }
  constexpr int size() const { return tilt_index() + (level ? 3 : 0); }
};

/// The velocity [angular; linear] in IMU axes [rad/s, m/s], from the state and the sample.
Vector6d corrected_velocity(const BodyVelocityModel& model, const State& x, const BodyVelocity& u);

/// One step of tau seconds. `u` is the velocity held over the step; it is used without a velocity
/// state. F is the exact derivative of the step. With a velocity state, Q contains the integrals of
/// its random walk: exact at a standstill, and of first order in tau |u| otherwise. Without, Q
/// contains the sample's noise held over the step (Du, eq. 12, with the missing Jacobian:
/// docs/derivations.md, D62).
Prediction predict(const BodyVelocityModel& model, const State& x, const BodyVelocity& u,
                   double tau, const BodyVelocityNoise& noise);

/// The sample as a measurement of the velocity state. If the pose has no level axes, the residual
/// is NaN and the update rejects it.
Measurement measure_velocity(const BodyVelocityModel& model, const State& x, const BodyVelocity& u,
                             const BodyVelocityNoise& noise);

}  // namespace chasles
