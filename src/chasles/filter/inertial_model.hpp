#pragma once

#include <span>

#include <Eigen/Core>

#include <chasles/filter/ekf.hpp>
#include <chasles/imu/strapdown.hpp>

namespace chasles {

/// The motion of a body that carries an IMU: the state has v_world, and `additive` is
/// [accelerometer bias 3, gyroscope bias 3]. Where the state has nav_T_world, gravity is turned by
/// its attitude; else the world's z axis points up and gravity is known in it.
struct InertialModel {
  static constexpr int kSize = 6;                           ///< additive states
  Eigen::Vector3d gravity_nav = {0, 0, -kStandardGravity};  ///< [m/s^2]
  ImuNoise noise;
};

/// Gravity in the world's axes [m/s^2].
Eigen::Vector3d gravity_world(const InertialModel& model, const State& x);

/// Position and velocity as they were predicted: with them, instead of what an update made of them,
/// the transition of first estimates is written (docs/derivations.md, D57).
struct PredictedMotion {
  Eigen::Vector3d p_world, v_world;
};
void use_first_estimates(const InertialModel& model, const State& x, double duration,
                         const PredictedMotion& before, Prediction& prediction);

/// The mean after some intervals and their linearisation as one step: the landmarks and their
/// correlations are touched once, however many samples there are. F and Q are the exact products of
/// strapdown's; the world's attitude psi moves gravity by R_nav^T [g]x psi (K&S, eq. 24).
Prediction predict(const InertialModel& model, const State& x,
                   std::span<const ImuInterval> intervals);
/// The same into a prediction that there is: of the heap it needs nothing if that has the size.
void predict(const InertialModel& model, const State& x, std::span<const ImuInterval> intervals,
             Prediction& result);

/// The motion in nav's axes, whatever the world's frame is, with the covariance of [rotation,
/// position, velocity, accelerometer bias, gyroscope bias], standard error (docs/derivations.md,
/// D53).
struct NavState {
  SE3 nav_T_imu;
  Eigen::Vector3d v_nav = Eigen::Vector3d::Zero();  ///< [m/s]
  Vector6d biases = Vector6d::Zero();               ///< accelerometer [m/s^2], gyroscope [rad/s]
  Matrix15d covariance = Matrix15d::Zero();
};
NavState nav_state(const Ekf& filter);

/// What nav_state writes on the way.
struct NavScratch {
  Eigen::MatrixXd derivative;  ///< d (NavState's errors) / d (errors of the core): 15 x core_size
  Eigen::MatrixXd product;
};
void find_nav_derivative(const State& x, NavScratch& scratch);
/// The motion with the covariance that the scratch's derivative makes.
NavState nav_state(const Ekf& filter, NavScratch& scratch);

}  // namespace chasles
