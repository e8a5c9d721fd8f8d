#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/filter/state.hpp>
#include <chasles/filter/textbook_motion_testing.hpp>
#include <chasles/lie/sek3.hpp>
#include <chasles/velocity/body_velocity_model.hpp>

/// A textbook extended Kalman filter in the coordinates of each chart. It uses the dense
/// transition, noise and measurement matrices of docs/derivations.md, D24 to D28 and D38, chart by
/// chart. The gain comes from an explicit inverse, the covariance from Joseph's form, with the
/// retraction of the chart and no reset of the covariance. It shares only the State with the
/// filter. Included by tests only.
namespace chasles::test {

class TextbookEkf {
 public:
  using Matrix = Eigen::MatrixXd;
  using Vector = Eigen::VectorXd;

  enum class Error { kStandard, kLeftSe3, kRightSe3, kRightSen3 };

  static Error error_named(std::string_view chart) {
    if (chart == "standard") return Error::kStandard;
    if (chart == "left-se3") return Error::kLeftSe3;
    return chart == "right-se3" ? Error::kRightSe3 : Error::kRightSen3;
  }

  /// The covariance is in the coordinates of the error.
  TextbookEkf(Error error, State initial, Matrix covariance)
      : error_(error), x_(std::move(initial)), P_(std::move(covariance)) {}

  const State& state() const { return x_; }
  const Matrix& covariance() const { return P_; }

  void propagate(const BodyVelocityModel& model, const BodyVelocity& u, double tau,
                 const BodyVelocityNoise& noise) {
    const int bias = 6 + model.bias_index();
    const int scale = 6 + model.scale_index();
    const double s = model.scale ? std::exp(x_.additive[model.scale_index()]) : 1;
    Vector6d velocity;
    velocity << u.angular_imu, u.linear_imu / s;
    if (model.velocity_state) {
      velocity = x_.additive.head<6>();
    } else if (model.gyro_bias) {
      velocity.head<3>() -= x_.additive.segment<3>(model.bias_index());
    }
    const SE3 step = se3::exp(tau * velocity);
    Matrix F = Matrix::Identity(P_.rows(), P_.rows());
    pose_by_pose(step, F);
    x_.world_T_imu = x_.world_T_imu * step;
    // B: effect of a change of the velocity on the errors, over tau.
    const Matrix B = errors_by_body_twist() * se3::right_jacobian(tau * velocity);
    Matrix Q = Matrix::Zero(P_.rows(), P_.rows());
    if (model.velocity_state) {
      F.middleCols<6>(6) += tau * B;
      const Matrix6d q = noise.walk.cwiseAbs2().asDiagonal();
      Q = tau * tau * tau / 3 * B * q * B.transpose();
      const Matrix cross = tau * tau / 2 * B * q;
      Q.middleCols<6>(6) += cross;
      Q.middleRows<6>(6) += cross.transpose();
      Q.block<6, 6>(6, 6) += tau * q;
    } else {
      if (model.gyro_bias) F.middleCols<3>(bias) -= tau * B.leftCols<3>();
      if (model.scale) F.col(scale) -= tau * B.rightCols<3>() * velocity.tail<3>();
      Vector6d sigma = tau * noise.sample_sigma;
      sigma.tail<3>() /= s;
      Q = B * sigma.cwiseAbs2().asDiagonal() * B.transpose();
    }
    for (int i = 0; i < 3 && model.gyro_bias; ++i) {
      Q(bias + i, bias + i) += tau * noise.gyro_bias_walk * noise.gyro_bias_walk;
    }
    if (model.scale) Q(scale, scale) += tau * noise.scale_walk * noise.scale_walk;
    P_ = F * P_ * F.transpose() + Q;
  }

  /// docs/derivations.md, D24 to D28; rows here: rotation 0, position 3, velocity 6, biases 9 and
  /// 12.
  void propagate(const Inertial& model, const InertialSample& u, double tau) {
    const Eigen::Matrix3d C = x_.world_T_imu.R;
    const Eigen::Vector3d f = u.f_imu - x_.additive.head<3>();
    const Eigen::Vector3d turn = tau * (u.w_imu - x_.additive.tail<3>());
    const State before = x_;
    x_ = model.step(x_, u, tau);
    const double half = tau * tau / 2;
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
    Matrix F = Matrix::Identity(P_.rows(), P_.rows());
    F.block<3, 3>(3, 6) = tau * I;
    F.block<3, 3>(3, 9) = -half * C;
    F.block<3, 3>(6, 9) = -tau * C;
    const Eigen::Matrix3d by_bias = -tau * C * so3::left_jacobian(turn);
    F.block<3, 3>(0, 12) = by_bias;
    switch (error_) {
      case Error::kStandard:
        F.block<3, 3>(3, 0) = -half * hat(C * f);
        F.block<3, 3>(6, 0) = -tau * hat(C * f);
        break;
      case Error::kLeftSe3: {
        const Eigen::Matrix3d Rt = so3::exp(-turn);
        const Eigen::Vector3d v = C.transpose() * *before.v_world;
        const Eigen::Vector3d g = C.transpose() * model.g_world;
        const Eigen::Vector3d v_next = Rt * (v + tau * (f + g));
        F.block<3, 3>(0, 0) = F.block<3, 3>(3, 3) = F.block<3, 3>(6, 6) = Rt;
        F.block<3, 3>(3, 6) = tau * Rt;
        F.block<3, 3>(3, 0) = Rt * (half * hat(g) - hat(v * tau + half * (f + g)));
        F.block<3, 3>(3, 9) = -half * Rt;
        F.block<3, 3>(6, 0) = tau * Rt * hat(g);
        F.block<3, 3>(6, 9) = -tau * Rt;
        F.block<3, 3>(6, 12) = -tau * hat(v_next) * so3::right_jacobian(turn);
        F.block<3, 3>(0, 12) = -tau * so3::right_jacobian(turn);
        break;
      }
      case Error::kRightSe3:
        F.block<3, 3>(3, 0) = hat(tau * *before.v_world + half * model.g_world);
        F.block<3, 3>(3, 12) = hat(x_.world_T_imu.p) * by_bias;
        F.block<3, 3>(6, 0) = -tau * hat(C * f);
        break;
      case Error::kRightSen3:
        F.block<3, 3>(3, 0) = half * hat(model.g_world);
        F.block<3, 3>(3, 12) = hat(x_.world_T_imu.p) * by_bias;
        F.block<3, 3>(6, 0) = tau * hat(model.g_world);
        F.block<3, 3>(6, 12) = hat(*x_.v_world) * by_bias;
        for (std::size_t i = 0; i < x_.landmarks.size(); ++i) {
          if (turns_with_pose(i)) {
            F.block<3, 3>(row(i), 12) = hat(x_.landmarks[i].p_world) * by_bias;
          }
        }
        break;
    }
    Matrix N = F.middleCols<6>(9);
    N.middleRows<6>(9).setZero();
    Vector sigma(6);
    sigma << model.f_sigma * Vector::Ones(3), model.w_sigma * Vector::Ones(3);
    P_ = F * P_ * F.transpose() + N * sigma.cwiseAbs2().asDiagonal() * N.transpose();
    for (int i = 0; i < 3; ++i) {
      P_(9 + i, 9 + i) += tau * model.f_bias_walk * model.f_bias_walk;
      P_(12 + i, 12 + i) += tau * model.w_bias_walk * model.w_bias_walk;
    }
  }

  void measure_velocity(const BodyVelocityModel& model, const BodyVelocity& u,
                        const Vector6d& sigma) {
    Matrix H = Matrix::Zero(6, P_.rows());
    Vector6d r;
    const double s = model.scale ? std::exp(x_.additive[model.scale_index()]) : 1;
    r << u.angular_imu - x_.additive.head<3>(), u.linear_imu - s * x_.additive.segment<3>(3);
    H.block<3, 3>(0, 6).setIdentity();
    H.block<3, 3>(3, 9) = s * Eigen::Matrix3d::Identity();
    if (model.gyro_bias) {
      r.head<3>() -= x_.additive.segment<3>(model.bias_index());
      H.block<3, 3>(0, 6 + model.bias_index()).setIdentity();
    }
    if (model.scale) {
      H.block<3, 1>(3, 6 + model.scale_index()) = s * x_.additive.segment<3>(3);
    }
    correct(H, r, sigma.cwiseAbs2().asDiagonal());
  }

  /// Mean u, mean v and disparity of landmarks of the state, each with this standard deviation.
  void measure(const StereoRig& rig, double sigma,
               const std::vector<std::pair<int, StereoObservation>>& observations) {
    const Eigen::Index m = 3 * static_cast<Eigen::Index>(observations.size());
    Matrix H = Matrix::Zero(m, P_.rows());
    Vector r(m);
    const Eigen::Matrix3d Ct = x_.world_T_imu.R.transpose();
    Eigen::Index at = 0;
    for (const auto& [index, seen] : observations) {
      const Eigen::Vector3d Y = x_.landmarks[static_cast<std::size_t>(index)].p_world;
      const Eigen::Vector3d y_b = Ct * (Y - x_.world_T_imu.p);
      const Eigen::Vector3d y_c = rig.cam0_T_imu * y_b;
      const double z = y_c.z();
      const double u = rig.fx * y_c.x() / z + rig.cx;
      const double v = rig.fy * y_c.y() / z + rig.cy;
      const double d = rig.fx * rig.baseline / z;
      r.segment<3>(at) << (seen.pixels[0] + seen.pixels[2]) / 2 - (u - d / 2),
          (seen.pixels[1] + seen.pixels[3]) / 2 - v, seen.pixels[0] - seen.pixels[2] - d;
      Eigen::Matrix3d D;
      D << rig.fx / z, 0, (d / 2 - (u - rig.cx)) / z,  //
          0, rig.fy / z, -(v - rig.cy) / z,            //
          0, 0, -d / z;
      const Eigen::Matrix3d A = D * rig.cam0_T_imu.R;  // by y_b
      auto rotation = H.block<3, 3>(at, 0);
      if (error_ == Error::kStandard) rotation = A * Ct * hat(Y - x_.world_T_imu.p);
      if (error_ == Error::kLeftSe3) rotation = A * hat(y_b);
      if (error_ == Error::kRightSe3) rotation = A * Ct * hat(Y);
      H.block<3, 3>(at, 3) = error_ == Error::kLeftSe3 ? Eigen::Matrix3d(-A) : -A * Ct;
      H.block<3, 3>(at, row(static_cast<std::size_t>(index))) = A * Ct;
      at += 3;
    }
    correct(H, r, sigma * sigma * Matrix::Identity(m, m));
  }

  void initialise(const StereoRig& rig, double sigma, const StereoObservation& seen) {
    const double d = seen.pixels[0] - seen.pixels[2];
    const double z = rig.fx * rig.baseline / d;
    const Eigen::Vector3d ray((seen.pixels[0] - rig.cx) / rig.fx,
                              ((seen.pixels[1] + seen.pixels[3]) / 2 - rig.cy) / rig.fy, 1);
    const Eigen::Matrix3d imu_R_cam0 = rig.cam0_T_imu.R.transpose();
    const Eigen::Vector3d y_b = imu_R_cam0 * (z * ray - rig.cam0_T_imu.p);
    const Eigen::Matrix3d C = x_.world_T_imu.R;
    const Eigen::Vector3d Y = x_.world_T_imu * y_b;
    Eigen::Matrix3d by_rows;  // mean u, mean v, disparity
    by_rows.col(0) = z / rig.fx * Eigen::Vector3d::UnitX();
    by_rows.col(1) = z / rig.fy * Eigen::Vector3d::UnitY();
    by_rows.col(2) = z / (2 * rig.fx) * Eigen::Vector3d::UnitX() - z / d * ray;
    const Eigen::Matrix3d noise = sigma * C * imu_R_cam0 * by_rows;
    Matrix J = Matrix::Zero(3, P_.rows());
    J.middleCols<3>(3) = error_ == Error::kLeftSe3 ? C : Eigen::Matrix3d::Identity();
    if (error_ == Error::kStandard) J.leftCols<3>() = -hat(C * y_b);
    if (error_ == Error::kLeftSe3) J.leftCols<3>() = -C * hat(y_b);
    if (error_ == Error::kRightSe3) J.leftCols<3>() = -hat(Y);
    const Eigen::Index n = P_.rows();
    Matrix P(n + 3, n + 3);
    P << P_, P_ * J.transpose(), J * P_, J * P_ * J.transpose() + noise * noise.transpose();
    P_ = P;
    x_.landmarks.push_back(
        {.id = seen.landmark, .p_world = Y, .row = static_cast<int>(n), .observations = 1});
    retired_.push_back(false);
  }

  /// Makes the landmark's error additive from now on.
  void retire(int index) {
    const std::size_t i = static_cast<std::size_t>(index);
    if (turns_with_pose(i)) {
      Matrix M = Matrix::Identity(P_.rows(), P_.rows());
      M.block<3, 3>(row(i), 0) = -hat(x_.landmarks[i].p_world);
      P_ = M * P_ * M.transpose();
    }
    retired_[i] = true;
  }

  bool retired(std::size_t index) const { return retired_[index]; }

 private:
  int row(std::size_t i) const { return x_.landmarks[i].row; }
  bool turns_with_pose(std::size_t i) const { return error_ == Error::kRightSen3 && !retired_[i]; }

  // Transition of the errors over a step: the block of the pose, with constant velocities.
  void pose_by_pose(const SE3& step, Matrix& F) const {
    if (error_ == Error::kStandard) F.block<3, 3>(3, 0) = -hat(x_.world_T_imu.R * step.p);
    if (error_ == Error::kLeftSe3) {
      const Eigen::Matrix3d Rt = step.R.transpose();
      F.block<3, 3>(0, 0) = F.block<3, 3>(3, 3) = Rt;
      F.block<3, 3>(3, 0) = -Rt * hat(step.p);
    }
  }

  // The errors of T Exp(eta) at the predicted pose T.
  Matrix errors_by_body_twist() const {
    const SE3& T = x_.world_T_imu;
    Matrix B = Matrix::Zero(P_.rows(), 6);
    B.topRows<6>().setIdentity();
    if (error_ == Error::kLeftSe3) return B;
    B.block<3, 3>(0, 0) = B.block<3, 3>(3, 3) = T.R;
    if (error_ == Error::kStandard) return B;
    B.block<3, 3>(3, 0) = hat(T.p) * T.R;
    for (std::size_t i = 0; i < x_.landmarks.size(); ++i) {
      if (turns_with_pose(i)) B.block<3, 3>(row(i), 0) = hat(x_.landmarks[i].p_world) * T.R;
    }
    return B;
  }

  void correct(const Matrix& H, const Vector& r, const Matrix& R) {
    const Matrix K = P_ * H.transpose() * (H * P_ * H.transpose() + R).inverse();
    const Matrix I_KH = Matrix::Identity(P_.rows(), P_.rows()) - K * H;
    P_ = I_KH * P_ * I_KH.transpose() + K * R * K.transpose();
    retract(K * r);
  }

  void retract(const Vector& xi) {
    SE3& T = x_.world_T_imu;
    const Eigen::Vector3d theta = xi.head<3>();
    const bool with_velocity = x_.v_world.has_value();
    std::size_t turned = 0;
    switch (error_) {
      case Error::kStandard:
        T = {so3::exp(theta) * T.R, T.p + xi.segment<3>(3)};
        if (with_velocity) *x_.v_world += xi.segment<3>(6);
        break;
      case Error::kLeftSe3: {
        const SE3 before = T;
        T = T * se3::exp(xi.head<6>());
        if (with_velocity) {
          x_.v_world = T.R * (before.R.transpose() * *x_.v_world + xi.segment<3>(6));
        }
        break;
      }
      case Error::kRightSe3:
        T = se3::exp(xi.head<6>()) * T;
        if (with_velocity) *x_.v_world += xi.segment<3>(6);
        break;
      case Error::kRightSen3:
        turned = retract_group(xi);
        break;
    }
    x_.additive += xi.segment(with_velocity ? 9 : 6, x_.additive.size());
    for (std::size_t i = 0; i < x_.landmarks.size(); ++i) {
      if (turned > 0 && !retired_[i]) continue;
      x_.landmarks[i].p_world += xi.segment<3>(row(i));
    }
  }

  // Pose, velocity and the landmarks that are not retired as one element of SE_{2+N}(3).
  std::size_t retract_group(const Vector& xi) {
    std::vector<Eigen::Vector3d*> vectors{&x_.world_T_imu.p};
    std::vector<int> rows{3};
    if (x_.v_world) {
      vectors.push_back(&*x_.v_world);
      rows.push_back(6);
    }
    for (std::size_t i = 0; i < x_.landmarks.size(); ++i) {
      if (retired_[i]) continue;
      vectors.push_back(&x_.landmarks[i].p_world);
      rows.push_back(row(i));
    }
    const Eigen::Index k = static_cast<Eigen::Index>(vectors.size());
    Vector tangent(3 + 3 * k);
    SEk3 X{x_.world_T_imu.R, Eigen::Matrix3Xd(3, k)};
    tangent.head<3>() = xi.head<3>();
    for (Eigen::Index i = 0; i < k; ++i) {
      tangent.segment<3>(3 + 3 * i) = xi.segment<3>(rows[static_cast<std::size_t>(i)]);
      X.x.col(i) = *vectors[static_cast<std::size_t>(i)];
    }
    X = sek3::exp(tangent) * X;
    x_.world_T_imu.R = X.R;
    for (Eigen::Index i = 0; i < k; ++i) *vectors[static_cast<std::size_t>(i)] = X.x.col(i);
    return vectors.size();
  }

  Error error_;
  State x_;
  Matrix P_;
  std::vector<bool> retired_;
};

}  // namespace chasles::test
