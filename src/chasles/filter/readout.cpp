#include <algorithm>

#include <chasles/camera/camera.hpp>
#include <chasles/filter/readout.hpp>

namespace chasles {

Eigen::Matrix3d MeasuredReadout::rotation_after(double seconds) const {
  return ReadoutMotion{.rate = rate, .rate_change = rate_change}.after(seconds).R;
}

ReadoutMotion MeasuredReadout::motion(const Eigen::Matrix3d& world_R_imu,
                                      const Eigen::Vector3d& v_world,
                                      const Eigen::Vector3d& gravity_world) const {
  return {.rate = rate,
          .rate_change = rate_change,
          .velocity = world_R_imu.transpose() * v_world,
          .acceleration = (world_R_imu.transpose() * gravity_world + force) / 2};
}

MeasuredReadout measured_readout(std::span<const ImuInterval> intervals, const Vector6d& biases) {
  double duration = 0;
  for (const ImuInterval& interval : intervals) duration += interval.tau;
  if (!(duration > 0)) return {};
  InertialState state;
  state.accelerometer_bias = biases.head<3>();
  state.gyroscope_bias = biases.tail<3>();
  Eigen::Vector3d half = Eigen::Vector3d::Zero();  // rotation in the middle
  double left = duration / 2;
  for (const ImuInterval& interval : intervals) {
    if (left > 0 && left <= interval.tau) {
      ImuInterval part = interval;
      part.tau = left;
      half = so3::log(integrate(state, part, Eigen::Vector3d::Zero()).world_T_imu.R);
    }
    left -= interval.tau;
    state = integrate(state, interval, Eigen::Vector3d::Zero());
  }
  const Eigen::Vector3d whole = so3::log(state.world_T_imu.R);
  const double square = duration * duration;
  return {.rate = (4 * half - whole) / duration,
          .rate_change = (2 * whole - 4 * half) / square,
          .force = 2 * state.world_T_imu.p / square};
}

double longest_readout(std::span<const Camera> cameras) {
  double longest = 0;
  for (const Camera& camera : cameras) longest = std::max(longest, camera.shutter.readout);
  return longest;
}

}  // namespace chasles
