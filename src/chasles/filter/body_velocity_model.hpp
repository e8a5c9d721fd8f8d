#pragma once

#include <Eigen/Core>

#include <chasles/filter/ekf.hpp>
#include <chasles/imu/body_velocity.hpp>

namespace chasles {

/// Densities and per-sample deviations of the body velocities; each Vector6 is [angular; linear],
/// as the pose's errors are ordered.
struct BodyVelocityNoise {
  Vector6d sample_sigma = Vector6d::Zero();  ///< white noise of one sample [rad/s, m/s]
  Vector6d walk = Vector6d::Zero();          ///< random walk of the velocity state [unit/sqrt(s)]
  double gyro_bias_walk = 0;                 ///< [rad/s/sqrt(s)]
  double scale_walk = 0;                     ///< of the velocity's scale [1/sqrt(s)]
  double tilt_walk = 0;                      ///< [rad/sqrt(s)]
  double heading_walk = 0;                   ///< [rad/sqrt(s)]
};

/// How body velocities move the pose (Du, eq. 6: T+ = T exp(tau u), exactly), and which states the
/// motion adds to the core's `additive` part:
///
///   [ velocity 6: angular, linear (imu axes) | gyroscope bias 3 | log of the velocity's scale 1 |
///     tilt 2 | heading 1 ]
///
/// With the velocity in the state, a sample is a noisy measurement of a slowly varying velocity;
/// without, it is the input that is integrated over the step, and its noise drives the pose.
///
/// With `level`, the samples are along level axes (imu/level_axes.hpp) turned by `heading`,
/// sample_R_imu = Rz(heading) level_R_imu, all in rad. Which way is up is estimated too:
/// nav_R_world = Exp([tilt, 0]). Only with a velocity state.
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

/// The velocity [angular; linear] in IMU axes that the state and the sample together stand for.
Vector6d corrected_velocity(const BodyVelocityModel& model, const State& x, const BodyVelocity& u);

/// One step of tau seconds. `u` is the velocity held over the step; used where it is not a state.
/// F is the exact derivative of the step. Q holds, for a velocity state, the integrals of its
/// random walk, exact at rest and of first order in tau |u| otherwise; otherwise the sample's noise
/// held over the step (Du, eq. 12, with the missing Jacobian: docs/derivations.md, D62).
Prediction predict(const BodyVelocityModel& model, const State& x, const BodyVelocity& u,
                   double tau, const BodyVelocityNoise& noise);

/// The sample as a measurement of the velocity state. Where the pose has no level axes the residual
/// is not a number, which an update refuses.
Measurement measure_velocity(const BodyVelocityModel& model, const State& x, const BodyVelocity& u,
                             const BodyVelocityNoise& noise);

}  // namespace chasles
