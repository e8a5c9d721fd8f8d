#pragma once

#include <span>

#include <Eigen/Core>

#include <chasles/filter/ekf.hpp>
#include <chasles/imu/strapdown.hpp>

namespace chasles {

/// The motion of a body with an IMU. The state has v_world, and `additive` is [accelerometer bias
/// 3, gyroscope bias 3]. If the state has nav_T_world, its attitude rotates gravity into the world.
/// Otherwise the world's z axis points up and gravity is known.
struct InertialModel {
  static constexpr int kSize = 6;                           ///< additive states
  Eigen::Vector3d gravity_nav = {0, 0, -kStandardGravity};  ///< [m/s^2]
  ImuNoise noise;
  /// The chart in which predict() propagates the covariance to first order
  /// (first_order_transition.hpp); null: the exact transition.
  const ErrorChart* first_order = nullptr;
};

/// Gravity in the world's axes [m/s^2].
Eigen::Vector3d gravity_world(const InertialModel& model, const State& x);

/// Predicted position and velocity [m, m/s]. The first-estimates transition uses them instead of
/// the updated values (docs/derivations.md, D57).
struct PredictedMotion {
  Eigen::Vector3d p_world, v_world;
};
void use_first_estimates(const InertialModel& model, const State& x, double duration,
                         const PredictedMotion& before, Prediction& prediction);

/// The mean after some intervals and its linearisation as one step, so that the correlations of the
/// landmarks are updated once, regardless of the number of samples. F and Q are the exact products
/// of those of strapdown(), or of those to first order (InertialModel::first_order). An error psi
/// of the world's attitude changes gravity by R_nav^T [g]x psi (K&S, eq. 24). Where the state has
/// parameters of the IMU, the intervals are corrected by them, and F has their columns
/// (docs/derivations.md, D66).
Prediction predict(const InertialModel& model, const State& x,
                   std::span<const ImuInterval> intervals);
/// The same into an existing prediction; allocates no heap memory if it has the right size.
void predict(const InertialModel& model, const State& x, std::span<const ImuInterval> intervals,
             Prediction& result);

/// The motion in the nav frame, independent of the world frame, with the covariance of [rotation,
/// position, velocity, accelerometer bias, gyroscope bias] in the standard chart
/// (docs/derivations.md, D53).
struct NavState {
  SE3 nav_T_imu;
  Eigen::Vector3d v_nav = Eigen::Vector3d::Zero();  ///< [m/s]
  Vector6d biases = Vector6d::Zero();               ///< accelerometer [m/s^2], gyroscope [rad/s]
  Matrix15d covariance = Matrix15d::Zero();
};
NavState nav_state(const Ekf& filter);

/// Workspace of nav_state.
struct NavScratch {
  Eigen::MatrixXd derivative;  ///< d (NavState's errors) / d (errors of the core): 15 x core_size
  Eigen::MatrixXd product;
};
void find_nav_derivative(const State& x, NavScratch& scratch);
/// The same, with the covariance from the derivative in `scratch`.
NavState nav_state(const Ekf& filter, NavScratch& scratch);

}  // namespace chasles
