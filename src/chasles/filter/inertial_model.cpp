#include <chasles/filter/first_order_transition.hpp>
#include <chasles/filter/inertial_model.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

InertialState inertial_state(const State& x) {
  return {.world_T_imu = x.world_T_imu,
          .v_world = x.v_world.value(),
          .accelerometer_bias = x.additive.head<3>(),
          .gyroscope_bias = x.additive.tail<3>()};
}

// The effect of the IMU's parameters on the motion. An error of a corrected sample acts like one of
// the bias with the other sign.
using ByImu = Eigen::Matrix<double, 9, Eigen::Dynamic, 0, 9, ImuCorrection::kMost>;
void move_on(const ImuCorrection& imu, const ImuInterval& measured, const Matrix15d& F,
             ByImu& by_imu) {
  const auto by_sample = imu.derivative(measured.specific_force_imu, measured.angular_rate_imu);
  by_imu = (F.topLeftCorner<9, 9>() * by_imu - F.topRightCorner<9, 6>() * by_sample).eval();
}

}  // namespace

Vector3d gravity_world(const InertialModel& model, const State& x) {
  return x.nav_T_world ? Vector3d(x.nav_T_world->R.transpose() * model.gravity_nav)
                       : model.gravity_nav;
}

Prediction predict(const InertialModel& model, const State& x,
                   std::span<const ImuInterval> intervals) {
  Prediction result;
  predict(model, x, intervals, result);
  return result;
}

void predict(const InertialModel& model, const State& x, std::span<const ImuInterval> intervals,
             Prediction& result) {
  const Vector3d gravity = gravity_world(model, x);
  InertialState state = inertial_state(x);
  Matrix15d F = Matrix15d::Identity();
  Matrix15d Q = Matrix15d::Zero();
  Eigen::Matrix<double, 15, 3> d_gravity = Eigen::Matrix<double, 15, 3>::Zero();
  ByImu by_imu = ByImu::Zero(9, x.imu ? x.imu->size() : 0);
  for (const ImuInterval& measured : intervals) {
    const ImuInterval interval = x.imu ? corrected(*x.imu, measured) : measured;
    StrapdownStep step = strapdown(state, interval, gravity, model.noise);
    if (model.first_order) {
      linearise_to_first_order(*model.first_order, state, interval, gravity, model.noise, step);
    }
    state = step.state;
    F = (step.F * F).eval();
    Q = (step.F * Q * step.F.transpose() + step.Q).eval();
    d_gravity = (step.F * d_gravity + step.d_gravity).eval();
    if (x.imu) move_on(*x.imu, measured, step.F, by_imu);
  }

  const int n = x.core_size();
  const int at = x.additive_row();
  result.world_T_imu = state.world_T_imu;
  result.v_world = state.v_world;
  result.additive = x.additive;
  result.F.setIdentity(n, n);
  result.Q.setZero(n, n);
  const auto embed = [&](const Matrix15d& from, MatrixXd& to) {
    to.topLeftCorner<9, 9>() = from.topLeftCorner<9, 9>();
    to.block<9, 6>(0, at) = from.topRightCorner<9, 6>();
    to.block<6, 9>(at, 0) = from.bottomLeftCorner<6, 9>();
    to.block<6, 6>(at, at) = from.bottomRightCorner<6, 6>();
  };
  embed(F, result.F);
  embed(Q, result.Q);
  if (x.imu) result.F.block(0, x.imu_row(), 9, x.imu->size()) = by_imu;
  if (x.nav_T_world) {
    result.F.block<9, 3>(0, x.nav_row()) =
        d_gravity.topRows<9>() * x.nav_T_world->R.transpose() * hat(model.gravity_nav);
  }
}

void use_first_estimates(const InertialModel& model, const State& x, double duration,
                         const PredictedMotion& before, Prediction& prediction) {
  const Vector3d gravity = gravity_world(model, x);
  const Vector3d& p = prediction.world_T_imu.p;
  prediction.F.block<3, 3>(3, 0) =
      -hat(p - before.p_world - duration * before.v_world - duration * duration / 2 * gravity);
  prediction.F.block<3, 3>(6, 0) = -hat(*prediction.v_world - before.v_world - duration * gravity);
}

void find_nav_derivative(const State& x, NavScratch& scratch) {
  const SE3 nav_T_world = x.nav_T_world.value_or(SE3{});
  const Matrix3d& R = nav_T_world.R;
  MatrixXd& J = scratch.derivative;
  J.setZero(15, x.core_size());
  for (const int row : {0, 3, 6}) J.block<3, 3>(row, row) = R;
  J.block<6, 6>(9, x.additive_row()).setIdentity();
  if (x.nav_T_world) {
    const int nav = x.nav_row();
    J.block<3, 3>(0, nav).setIdentity();
    J.block<3, 3>(3, nav) = -hat(R * x.world_T_imu.p);
    J.block<3, 3>(3, nav + 3).setIdentity();
    J.block<3, 3>(6, nav) = -hat(R * *x.v_world);
  }
}

NavState nav_state(const Ekf& filter, NavScratch& scratch) {
  const State& x = filter.state();
  const int n = x.core_size();
  scratch.product.noalias() = scratch.derivative * filter.covariance().topLeftCorner(n, n);
  const SE3 nav_T_world = x.nav_T_world.value_or(SE3{});
  return {.nav_T_imu = nav_T_world * x.world_T_imu,
          .v_nav = nav_T_world.R * *x.v_world,
          .biases = x.additive,
          .covariance = scratch.product * scratch.derivative.transpose()};
}

NavState nav_state(const Ekf& filter) {
  NavScratch scratch;
  find_nav_derivative(filter.state(), scratch);
  return nav_state(filter, scratch);
}

}  // namespace chasles
