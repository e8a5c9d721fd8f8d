#include <chasles/initialise/preintegration.hpp>

namespace chasles {
namespace {

InertialState no_motion(const Vector6d& biases) {
  InertialState state;
  state.accelerometer_bias = biases.head<3>();
  state.gyroscope_bias = biases.tail<3>();
  return state;
}

}  // namespace

Preintegration preintegrate(const std::vector<ImuInterval>& intervals, const Vector6d& biases,
                            const ImuNoise& noise) {
  Preintegration p{.delta = no_motion(biases), .d_bias = Eigen::Matrix<double, 9, 6>::Zero()};
  const ImuNoise white{.accelerometer_noise_density = noise.accelerometer_noise_density,
                       .gyroscope_noise_density = noise.gyroscope_noise_density};
  for (const ImuInterval& interval : intervals) {
    const StrapdownStep step = strapdown(p.delta, interval, Eigen::Vector3d::Zero(), white);
    const Matrix9d F = step.F.topLeftCorner<9, 9>();
    p.d_bias = (F * p.d_bias + step.F.topRightCorner<9, 6>()).eval();
    p.Q = (F * p.Q * F.transpose() + step.Q.topLeftCorner<9, 9>()).eval();
    p.delta = step.state;
    p.seconds += interval.tau;
  }
  return p;
}

void set_biases(const std::vector<ImuInterval>& intervals, const Vector6d& biases,
                Preintegration& p) {
  p.delta = no_motion(biases);
  for (const ImuInterval& interval : intervals) {
    p.delta = integrate(p.delta, interval, Eigen::Vector3d::Zero());
  }
}

InertialState moved(const InertialState& state, const Preintegration& p,
                    const Eigen::Vector3d& gravity) {
  const double t = p.seconds;
  InertialState next = state;
  next.world_T_imu.R = state.world_T_imu.R * p.delta.world_T_imu.R;
  next.world_T_imu.p +=
      t * state.v_world + t * t / 2 * gravity + state.world_T_imu.R * p.delta.world_T_imu.p;
  next.v_world += t * gravity + state.world_T_imu.R * p.delta.v_world;
  return next;
}

Eigen::Matrix<double, 9, 15> d_moved(const InertialState& state, const Preintegration& p) {
  const Eigen::Matrix3d& R = state.world_T_imu.R;
  Eigen::Matrix<double, 9, 15> F = Eigen::Matrix<double, 9, 15>::Identity();
  F.block<3, 3>(3, 0) = -hat(R * p.delta.world_T_imu.p);
  F.block<3, 3>(3, 6).diagonal().setConstant(p.seconds);
  F.block<3, 3>(6, 0) = -hat(R * p.delta.v_world);
  for (int row = 0; row < 9; row += 3) {
    F.block<3, 6>(row, 9) = R * p.d_bias.middleRows<3>(row);
  }
  return F;
}

}  // namespace chasles
