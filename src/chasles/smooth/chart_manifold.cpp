#include <Eigen/LU>

#include <chasles/lie/so3.hpp>
#include <chasles/smooth/chart_manifold_detail.hpp>

namespace chasles::smooth_detail {
namespace {

using ErrorMap = Eigen::Map<Eigen::Matrix<double, kMotionErrors, 1>>;
using ConstErrorMap = Eigen::Map<const Eigen::Matrix<double, kMotionErrors, 1>>;

State motion_state(const double* x) {
  State state;
  state.world_T_imu.R = Eigen::Map<const Eigen::Matrix3d>(x);
  state.world_T_imu.p = Eigen::Map<const Eigen::Vector3d>(x + 9);
  state.v_world = Eigen::Map<const Eigen::Vector3d>(x + 12);
  return state;
}

}  // namespace

void write_motion(const InertialState& state, double* x) {
  Eigen::Map<Eigen::Matrix3d>{x} = state.world_T_imu.R;
  Eigen::Map<Eigen::Vector3d>{x + 9} = state.world_T_imu.p;
  Eigen::Map<Eigen::Vector3d>{x + 12} = state.v_world;
}

void read_motion(const double* x, InertialState& state) {
  state.world_T_imu.R = Eigen::Map<const Eigen::Matrix3d>(x);
  state.world_T_imu.p = Eigen::Map<const Eigen::Vector3d>(x + 9);
  state.v_world = Eigen::Map<const Eigen::Vector3d>(x + 12);
}

bool ChartManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  State state = motion_state(x);
  chart_->retract(state, ConstErrorMap(delta));
  write_motion(
      {.world_T_imu = {.R = so3::normalized(state.world_T_imu.R), .p = state.world_T_imu.p},
       .v_world = *state.v_world},
      x_plus_delta);
  return true;
}

bool ChartManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, kMotionNumbers, kMotionErrors, Eigen::RowMajor>> J(jacobian);
  J.setZero();
  J.topRows<kMotionErrors>() = chart_->motion_block(motion_state(x)).inverse();
  return true;
}

bool ChartManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  ErrorMap{y_minus_x} = chart_->local(motion_state(x), motion_state(y));
  return true;
}

bool ChartManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, kMotionErrors, kMotionNumbers, Eigen::RowMajor>> J(jacobian);
  J.setZero();
  J.leftCols<kMotionErrors>() = chart_->motion_block(motion_state(x));
  return true;
}

}  // namespace chasles::smooth_detail
