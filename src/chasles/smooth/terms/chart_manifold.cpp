#include <chasles/lie/small_matrices.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/smooth/terms/chart_manifold_detail.hpp>

namespace chasles::smooth_detail {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

void write_pose(const SE3& world_T_imu, double* x) {
  Eigen::Map<Eigen::Matrix3d>{x} = world_T_imu.R;
  Eigen::Map<Eigen::Vector3d>{x + 9} = world_T_imu.p;
}

SE3 read_pose(const double* x) {
  return {.R = Eigen::Map<const Eigen::Matrix3d>(x), .p = Eigen::Map<const Eigen::Vector3d>(x + 9)};
}

void write_motion(const InertialState& state, double* x) {
  write_pose(state.world_T_imu, x);
  Eigen::Map<Eigen::Vector3d>{x + kPoseNumbers} = state.v_world;
}

void write_state(const InertialState& state, double* motion, double* biases) {
  write_motion(state, motion);
  Eigen::Map<Vector6d>{biases} = state.biases();
}

InertialState read_state(const double* motion, const double* biases) {
  return {.world_T_imu = read_pose(motion),
          .v_world = Eigen::Map<const Eigen::Vector3d>(motion + kPoseNumbers),
          .accelerometer_bias = Eigen::Map<const Eigen::Vector3d>(biases),
          .gyroscope_bias = Eigen::Map<const Eigen::Vector3d>(biases + 3)};
}

State ChartManifold::state_of(const double* x) const {
  State state;
  state.world_T_imu = read_pose(x);
  if (velocity_) state.v_world = Eigen::Map<const Eigen::Vector3d>(x + kPoseNumbers);
  return state;
}

bool ChartManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  State state = state_of(x);
  chart_->retract(state, Eigen::Map<const Eigen::VectorXd>(delta, TangentSize()));
  write_pose({.R = so3::normalized(state.world_T_imu.R), .p = state.world_T_imu.p}, x_plus_delta);
  if (velocity_) Eigen::Map<Eigen::Vector3d>{x_plus_delta + kPoseNumbers} = *state.v_world;
  return true;
}

bool ChartManifold::PlusJacobian(const double* x, double* jacobian) const {
  const int n = TangentSize();
  Eigen::Map<RowMajor> J(jacobian, AmbientSize(), n);
  J.setZero();
  if (velocity_) {
    J.topRows<kMotionErrors>() = inverse(chart_->motion_block(state_of(x)));
  } else {
    J.topRows<kPoseErrors>() = inverse<kPoseErrors>(
        chart_->motion_block(state_of(x)).topLeftCorner<kPoseErrors, kPoseErrors>());
  }
  return true;
}

bool ChartManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<Eigen::VectorXd>(y_minus_x, TangentSize()) = chart_->local(state_of(x), state_of(y));
  return true;
}

bool ChartManifold::MinusJacobian(const double* x, double* jacobian) const {
  const int n = TangentSize();
  Eigen::Map<RowMajor> J(jacobian, n, AmbientSize());
  J.setZero();
  J.leftCols(n) = chart_->motion_block(state_of(x)).topLeftCorner(n, n);
  return true;
}

}  // namespace chasles::smooth_detail
