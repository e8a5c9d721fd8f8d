#include <cmath>

#include <chasles/filter/body_velocity_model.hpp>

namespace chasles {
namespace {

Vector6d as_vector(const BodyVelocity& u) {
  Vector6d result;
  result << u.angular_imu, u.linear_imu;
  return result;
}

double scale_of(const BodyVelocityModel& model, const State& x) {
  return model.scale ? std::exp(x.additive[model.scale_index()]) : 1.0;
}

// d (pose errors, reference chart) / d (twist tau * u): the pose turns by Exp(Jl(xi) d) in front of
// Exp(xi), and the reference chart takes that apart into world axes.
Matrix6d pose_by_twist(const SE3& world_T_imu, const SE3& step, const Vector6d& xi) {
  Matrix6d to_reference = Matrix6d::Identity();
  to_reference.block<3, 3>(3, 0) = -hat(step.p);
  Matrix6d rotation = Matrix6d::Zero();
  rotation.topLeftCorner<3, 3>() = world_T_imu.R;
  rotation.bottomRightCorner<3, 3>() = world_T_imu.R;
  return rotation * to_reference * se3::left_jacobian(xi);
}

}  // namespace

Vector6d corrected_velocity(const BodyVelocityModel& model, const State& x, const BodyVelocity& u) {
  if (model.velocity_state) return x.additive.head<6>();
  Vector6d result = as_vector(u);
  if (model.gyro_bias) result.head<3>() -= x.additive.segment<3>(model.bias_index());
  result.tail<3>() /= scale_of(model, x);
  return result;
}

Prediction predict(const BodyVelocityModel& model, const State& x, const BodyVelocity& u,
                   double tau, const BodyVelocityNoise& noise) {
  const Vector6d velocity = corrected_velocity(model, x, u);
  const Vector6d xi = tau * velocity;
  const SE3 step = se3::exp(xi);
  const int n = x.core_size();
  const int at = x.additive_row();
  const Matrix6d J = pose_by_twist(x.world_T_imu, step, xi);

  Prediction result{.world_T_imu = x.world_T_imu * step,
                    .v_world = x.v_world,
                    .additive = x.additive,
                    .F = Eigen::MatrixXd::Identity(n, n),
                    .Q = Eigen::MatrixXd::Zero(n, n)};
  auto& F = result.F;
  auto& Q = result.Q;
  F.block<3, 3>(3, 0) = -hat(x.world_T_imu.R * step.p);
  if (model.velocity_state) {
    F.block<6, 6>(0, at) = tau * J;
    const Matrix6d q = noise.walk.cwiseAbs2().asDiagonal();
    Q.topLeftCorner<6, 6>() = tau * tau * tau / 3 * J * q * J.transpose();
    Q.block<6, 6>(0, at) = tau * tau / 2 * J * q;
    Q.block<6, 6>(at, 0) = Q.block<6, 6>(0, at).transpose();
    Q.block<6, 6>(at, at) = tau * q;
  } else {
    if (model.gyro_bias) F.block<6, 3>(0, at + model.bias_index()) = -tau * J.leftCols<3>();
    if (model.scale) {
      F.block<6, 1>(0, at + model.scale_index()) = -tau * J.rightCols<3>() * velocity.tail<3>();
    }
    Vector6d sigma = noise.sample_sigma;
    sigma.tail<3>() /= scale_of(model, x);
    Q.topLeftCorner<6, 6>() = tau * tau * J * sigma.cwiseAbs2().asDiagonal() * J.transpose();
  }
  if (model.gyro_bias) {
    const int row = at + model.bias_index();
    Q.block<3, 3>(row, row).diagonal().setConstant(tau * noise.gyro_bias_walk *
                                                   noise.gyro_bias_walk);
  }
  if (model.scale) {
    const int row = at + model.scale_index();
    Q(row, row) = tau * noise.scale_walk * noise.scale_walk;
  }
  return result;
}

Measurement measure_velocity(const BodyVelocityModel& model, const State& x, const BodyVelocity& u,
                             const BodyVelocityNoise& noise) {
  const double scale = scale_of(model, x);
  Vector6d expected = x.additive.head<6>();
  expected.tail<3>() *= scale;
  Measurement result;
  result.core_column = x.additive_row();
  result.d_core.setZero(6, model.size());
  result.d_core.leftCols<6>().diagonal() << 1, 1, 1, scale, scale, scale;
  if (model.gyro_bias) {
    expected.head<3>() += x.additive.segment<3>(model.bias_index());
    result.d_core.block<3, 3>(0, model.bias_index()).setIdentity();
  }
  if (model.scale) result.d_core.block<3, 1>(3, model.scale_index()) = expected.tail<3>();
  result.residual = as_vector(u) - expected;
  result.noise = noise.sample_sigma.cwiseAbs2().asDiagonal();
  return result;
}

}  // namespace chasles
