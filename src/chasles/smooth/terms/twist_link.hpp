#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/velocity/body_velocity_model.hpp>

namespace chasles {

/// The motion between two instants of a recording with body velocities: the filter's motion model
/// (velocity/body_velocity_model.hpp) as a term between the pose and additive states of one instant
/// and of the next. Rows of the residual: the twist [rotation; translation] from the first pose to
/// the second minus the velocity times tau, then the later additive states minus the earlier. In
/// these coordinates the model's noise does not depend on the state. With q the density of the
/// walk, it is the integrals [tau^3/3, tau^2/2; tau^2/2, tau] q of a velocity state, otherwise the
/// noise of a held sample.
struct TwistLink {
  BodyVelocityModel model;
  double tau = 0;             ///< [s]
  BodyVelocity held;          ///< over the step; used where the velocity is not a state
  Eigen::MatrixXd whitening;  ///< lower triangular W, W^T W = covariance^-1
  int size() const { return 6 + model.size(); }
};

/// A walk below 1e-7 is replaced by 1e-7. Throws InputError where the pose has no noise: a walk of
/// a velocity state, or a sigma of a sample as input, that is zero.
TwistLink twist_link(const BodyVelocityModel& model, double tau, const BodyVelocity& held,
                     const BodyVelocityNoise& noise);

/// Pose and additive states of one instant.
struct VelocityState {
  SE3 world_T_imu;
  Eigen::VectorXd additive;
};

/// The residual, whitened, and optionally its derivatives by the errors [rotation; position;
/// additive] of both in the reference chart.
struct TwistDerivatives {
  Eigen::MatrixXd now, next;
};
Eigen::VectorXd twist_residual(const TwistLink& link, const VelocityState& now,
                               const VelocityState& next, TwistDerivatives* derivatives = nullptr);

}  // namespace chasles
