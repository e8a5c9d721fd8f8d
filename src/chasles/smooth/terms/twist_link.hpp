#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/filter/body_velocity_model.hpp>

namespace chasles {

/// What moves between two instants of a recording with body velocities: the filter's motion model
/// (filter/body_velocity_model.hpp) as a tie between a pose with its additive states and the next.
/// The residual's rows are those of the twist [rotation; translation] that leads from the one pose
/// to the other, less the velocity times tau, and of the later additive states less the earlier. In
/// these coordinates the model's noise is the same wherever one is: with q the walk's density, the
/// integrals [tau^3/3, tau^2/2; tau^2/2, tau] q of a velocity state, else a sample's noise that is
/// held.
struct TwistLink {
  BodyVelocityModel model;
  double tau = 0;             ///< [s]
  BodyVelocity held;          ///< over the step; used where the velocity is not a state
  Eigen::MatrixXd whitening;  ///< lower triangular W, W^T W = covariance^-1
  int size() const { return 6 + model.size(); }
};

/// A walk below 1e-7 counts as that. Throws InputError where the noise leaves a pose no freedom: a
/// walk of a velocity state, or a sample's deviation of an input, that is zero.
TwistLink twist_link(const BodyVelocityModel& model, double tau, const BodyVelocity& held,
                     const BodyVelocityNoise& noise);

/// Pose and additive states of one instant.
struct VelocityState {
  SE3 world_T_imu;
  Eigen::VectorXd additive;
};

/// The residual, whitened, and where asked for its derivatives by the errors [rotation; position;
/// additive] of both in the reference chart.
struct TwistDerivatives {
  Eigen::MatrixXd now, next;
};
Eigen::VectorXd twist_residual(const TwistLink& link, const VelocityState& now,
                               const VelocityState& next, TwistDerivatives* derivatives = nullptr);

}  // namespace chasles
