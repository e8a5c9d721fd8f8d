#include <algorithm>
#include <cmath>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/smooth/batch/floors_detail.hpp>
#include <chasles/smooth/terms/twist_link.hpp>

namespace chasles {

namespace {

Eigen::MatrixXd covariance(const BodyVelocityModel& model, double tau,
                           const BodyVelocityNoise& noise) {
  const int n = 6 + model.size();
  Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(n, n);
  if (model.velocity_state) {
    const Vector6d q = noise.walk.cwiseAbs2();
    Q.block<6, 6>(0, 0).diagonal() = tau * tau * tau / 3 * q;
    Q.block<6, 6>(0, 6).diagonal() = tau * tau / 2 * q;
    Q.block<6, 6>(6, 0).diagonal() = tau * tau / 2 * q;
    Q.block<6, 6>(6, 6).diagonal() = tau * q;
  } else {
    Q.topLeftCorner<6, 6>().diagonal() = tau * tau * noise.sample_sigma.cwiseAbs2();
  }
  const auto walk = [&](double sigma) {
    return tau * std::pow(std::max(sigma, smooth_detail::kLeastWalk), 2);
  };
  if (model.gyro_bias) {
    Q.diagonal().segment<3>(6 + model.bias_index()).setConstant(walk(noise.gyro_bias_walk));
  }
  if (model.scale) Q.diagonal()[6 + model.scale_index()] = walk(noise.scale_walk);
  if (model.level) {
    Q.diagonal().segment<2>(6 + model.tilt_index()).setConstant(walk(noise.tilt_walk));
    Q.diagonal()[6 + model.heading_index()] = walk(noise.heading_walk);
  }
  return Q;
}

// The scale of an input applies to the twist, so that the noise is the sample's own.
double input_scale(const BodyVelocityModel& model, const VelocityState& now) {
  return model.scale && !model.velocity_state ? std::exp(now.additive[model.scale_index()]) : 1.0;
}

TwistDerivatives derivatives_at(const TwistLink& link, const VelocityState& now, const SE3& step,
                                const Vector6d& xi) {
  const BodyVelocityModel& model = link.model;
  const int n = link.size();
  const double scale = input_scale(model, now);
  const Eigen::Matrix3d Rt = now.world_T_imu.R.transpose();
  Matrix6d by_next = Matrix6d::Zero(), by_now = Matrix6d::Zero();
  by_next.topLeftCorner<3, 3>() = by_next.bottomRightCorner<3, 3>() = Rt;
  by_next.block<3, 3>(3, 0) = hat(step.p) * Rt;
  by_now.topLeftCorner<3, 3>() = by_now.bottomRightCorner<3, 3>() = -Rt;
  Vector6d scales;
  scales << 1, 1, 1, scale, scale, scale;
  const Matrix6d by_step = scales.asDiagonal() * se3::left_jacobian_inverse(xi);
  Eigen::MatrixXd next = Eigen::MatrixXd::Identity(n, n);
  Eigen::MatrixXd before = -next;
  next.topLeftCorner<6, 6>() = by_step * by_next;
  before.topLeftCorner<6, 6>() = by_step * by_now;
  if (model.velocity_state) {
    before.block<6, 6>(0, 6).diagonal().setConstant(-link.tau);
  } else {
    if (model.gyro_bias) {
      before.block<3, 3>(0, 6 + model.bias_index()).diagonal().setConstant(link.tau);
    }
    if (model.scale) before.block<3, 1>(3, 6 + model.scale_index()) = scale * xi.tail<3>();
  }
  return {.now = link.whitening * before, .next = link.whitening * next};
}

}  // namespace

TwistLink twist_link(const BodyVelocityModel& model, double tau, const BodyVelocity& held,
                     const BodyVelocityNoise& noise) {
  const Eigen::MatrixXd Q = covariance(model, tau, noise);
  std::optional<Eigen::MatrixXd> whitening = whitening_of(Q);
  if (!whitening) {
    throw InputError(
        "the motion between two instants has no noise: expected velocity_walk and rate_walk "
        "(velocity_sigma and rate_sigma with velocity=input) above 0 and finite");
  }
  return {.model = model, .tau = tau, .held = held, .whitening = std::move(*whitening)};
}

Eigen::VectorXd twist_residual(const TwistLink& link, const VelocityState& now,
                               const VelocityState& next, TwistDerivatives* derivatives) {
  const BodyVelocityModel& model = link.model;
  const SE3 step = now.world_T_imu.inverse() * next.world_T_imu;
  const Vector6d xi = se3::log(step);
  Eigen::VectorXd r(link.size());
  r.tail(model.size()) = next.additive - now.additive;
  if (model.velocity_state) {
    r.head<6>() = xi - link.tau * now.additive.head<6>();
  } else {
    r.head<3>() = xi.head<3>() - link.tau * link.held.angular_imu;
    if (model.gyro_bias) r.head<3>() += link.tau * now.additive.segment<3>(model.bias_index());
    r.segment<3>(3) = input_scale(model, now) * xi.tail<3>() - link.tau * link.held.linear_imu;
  }
  if (derivatives != nullptr) *derivatives = derivatives_at(link, now, step, xi);
  return link.whitening * r;
}

}  // namespace chasles
