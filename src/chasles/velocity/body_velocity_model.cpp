#include <cmath>
#include <limits>
#include <optional>

#include <chasles/velocity/body_velocity_model.hpp>
#include <chasles/velocity/level_axes.hpp>

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

// d (pose errors, reference chart) / d (twist tau * u): the pose moves by Exp(Jl(xi) d) in front of
// Exp(xi), expressed in world axes for the reference chart.
Matrix6d pose_by_twist(const SE3& world_T_imu, const SE3& step, const Vector6d& xi) {
  Matrix6d to_reference = Matrix6d::Identity();
  to_reference.block<3, 3>(3, 0) = -hat(step.p);
  Matrix6d rotation = Matrix6d::Zero();
  rotation.topLeftCorner<3, 3>() = world_T_imu.R;
  rotation.bottomRightCorner<3, 3>() = world_T_imu.R;
  return rotation * to_reference * se3::left_jacobian(xi);
}

static_assert(6 +
                  BodyVelocityModel{
                      .velocity_state = true, .gyro_bias = true, .scale = true, .level = true}
                      .size() <=
              Measurement::kMaxCoreColumns);

// Predicted sample in level axes, from the prediction in IMU axes, with the derivatives by pose,
// velocity, tilt and heading.
void turn_to_level(const BodyVelocityModel& model, const State& x, int additive_column,
                   Vector6d& expected, Measurement& z) {
  const Eigen::Vector3d tilt(x.additive[model.tilt_index()], x.additive[model.tilt_index() + 1], 0);
  const Eigen::Vector3d up_world = so3::exp(-tilt) * Eigen::Vector3d::UnitZ();
  const Eigen::Matrix3d imu_R_world = x.world_T_imu.R.transpose();
  const std::optional<LevelAxes> axes = level_axes(imu_R_world * up_world);
  if (!axes) {
    expected.setConstant(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  const double heading = x.additive[model.heading_index()];
  const Eigen::Matrix3d turn = so3::exp(heading * Eigen::Vector3d::UnitZ());
  const Eigen::Matrix3d sample_R_imu = turn * axes->level_R_imu;
  const Eigen::Matrix3d up_by_theta = imu_R_world * hat(up_world);
  const Eigen::Matrix3d up_by_tilt = up_by_theta * so3::left_jacobian(-tilt);
  const Eigen::Matrix3d turn_by_up = turn * axes->by_vertical;
  for (const int row : {0, 3}) {
    const Eigen::Vector3d w = sample_R_imu * expected.segment<3>(row);
    const Eigen::Matrix3d by_up = -hat(w) * turn_by_up;
    z.d_core.block<3, 3>(row, 0) = by_up * up_by_theta;
    z.d_core.block<3, 2>(row, additive_column + model.tilt_index()) =
        by_up * up_by_tilt.leftCols<2>();
    z.d_core.block<3, 1>(row, additive_column + model.heading_index()) =
        Eigen::Vector3d(-w.y(), w.x(), 0);
    z.d_core.block<3, 3>(row, additive_column + row) =
        (row == 0 ? 1.0 : scale_of(model, x)) * sample_R_imu;
    expected.segment<3>(row) = w;
  }
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
  if (model.level) {
    const int row = at + model.tilt_index();
    Q.block<2, 2>(row, row).diagonal().setConstant(tau * noise.tilt_walk * noise.tilt_walk);
    Q(row + 2, row + 2) = tau * noise.heading_walk * noise.heading_walk;
  }
  return result;
}

Measurement measure_velocity(const BodyVelocityModel& model, const State& x, const BodyVelocity& u,
                             const BodyVelocityNoise& noise) {
  const double scale = scale_of(model, x);
  Vector6d expected = x.additive.head<6>();
  expected.tail<3>() *= scale;
  Measurement result;
  result.core_column = model.level ? 0 : x.additive_row();
  const int at = x.additive_row() - result.core_column;
  result.d_core.setZero(6, at + model.size());
  result.d_core.middleCols<6>(at).diagonal() << 1, 1, 1, scale, scale, scale;
  if (model.level) turn_to_level(model, x, at, expected, result);
  if (model.scale) result.d_core.block<3, 1>(3, at + model.scale_index()) = expected.tail<3>();
  if (model.gyro_bias) {
    expected.head<3>() += x.additive.segment<3>(model.bias_index());
    result.d_core.block<3, 3>(0, at + model.bias_index()).setIdentity();
  }
  result.residual = as_vector(u) - expected;
  result.noise = noise.sample_sigma.cwiseAbs2().asDiagonal();
  return result;
}

}  // namespace chasles
