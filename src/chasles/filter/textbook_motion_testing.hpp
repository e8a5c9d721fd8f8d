#pragma once

#include <Eigen/Core>

#include <chasles/filter/ekf.hpp>

/// An inertial motion model for tests of filter states with a velocity. Included by tests only.
namespace chasles::test {

/// Specific force and angular rate as measured, held over a step.
struct InertialSample {
  Eigen::Vector3d f_imu = Eigen::Vector3d::Zero();  ///< [m/s^2]
  Eigen::Vector3d w_imu = Eigen::Vector3d::Zero();  ///< [rad/s]
};

/// Kleinert & Stilla (19)-(22): the attitude at the start of the step rotates the specific force.
/// State::additive is [accelerometer bias; gyroscope bias].
struct Inertial {
  Eigen::Vector3d g_world{0, 0, -9.81};
  double f_sigma = 0, w_sigma = 0;          ///< of one sample
  double f_bias_walk = 0, w_bias_walk = 0;  ///< [unit/sqrt(s)]

  State step(State x, const InertialSample& u, double tau) const {
    const Eigen::Vector3d a = x.world_T_imu.R * (u.f_imu - x.additive.head<3>()) + g_world;
    const Eigen::Vector3d turn = tau * (u.w_imu - x.additive.tail<3>());
    x.world_T_imu.p += tau * *x.v_world + tau * tau / 2 * a;
    *x.v_world += tau * a;
    x.world_T_imu.R = x.world_T_imu.R * so3::exp(turn);
    return x;
  }

  /// The step and its derivative in the standard chart (docs/derivations.md, D24).
  Prediction predict(const State& x, const InertialSample& u, double tau) const {
    const State next = step(x, u, tau);
    const Eigen::Matrix3d C = x.world_T_imu.R;
    const Eigen::Matrix3d f = hat(C * (u.f_imu - x.additive.head<3>()));
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
    Eigen::MatrixXd F = Eigen::MatrixXd::Identity(15, 15);
    F.block<3, 3>(3, 0) = -tau * tau / 2 * f;
    F.block<3, 3>(3, 6) = tau * I;
    F.block<3, 3>(3, 9) = -tau * tau / 2 * C;
    F.block<3, 3>(6, 0) = -tau * f;
    F.block<3, 3>(6, 9) = -tau * C;
    F.block<3, 3>(0, 12) = -tau * C * so3::left_jacobian(tau * (u.w_imu - x.additive.tail<3>()));
    Eigen::MatrixXd N = F.rightCols<6>();
    N.bottomRows<6>().setZero();
    return {.world_T_imu = next.world_T_imu,
            .v_world = next.v_world,
            .additive = next.additive,
            .F = F,
            .Q = noise(N, tau)};
  }

  /// Covariance of the errors that a step adds: of the sample, which has the effect N (n x 6) on
  /// the n errors, and of the random walk of the biases in rows 9 to 14.
  Eigen::MatrixXd noise(const Eigen::MatrixXd& N, double tau) const {
    Eigen::VectorXd sigma(6), walk = Eigen::VectorXd::Zero(N.rows());
    sigma << f_sigma * Eigen::Vector3d::Ones(), w_sigma * Eigen::Vector3d::Ones();
    walk.segment<3>(9).setConstant(f_bias_walk);
    walk.segment<3>(12).setConstant(w_bias_walk);
    Eigen::MatrixXd Q = N * sigma.cwiseAbs2().asDiagonal() * N.transpose();
    Q.diagonal() += tau * walk.cwiseAbs2();
    return Q;
  }
};

}  // namespace chasles::test
