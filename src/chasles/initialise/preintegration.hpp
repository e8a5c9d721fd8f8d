#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/imu/strapdown.hpp>

namespace chasles {

using Matrix9d = Eigen::Matrix<double, 9, 9>;

/// The motion between two keyframes from the samples alone, without gravity, from identity and zero
/// velocity, in the axes of the first keyframe (idea: Forster, Carlone, Dellaert & Scaramuzza
/// 2017). The exact strapdown map commutes with the initial pose, so that
///   R+ = R dR,  v+ = v + g t + R dv,  p+ = p + v t + g t^2 / 2 + R dp
struct Preintegration {
  double seconds = 0;
  InertialState delta;  ///< dR, dp [m], dv [m/s], at the biases that it holds
  Eigen::Matrix<double, 9, 6>
      d_bias;  ///< d [rotation, position, velocity] / d biases, at these biases
  Matrix9d Q =
      Matrix9d::Zero();  ///< covariance of [rotation, position, velocity] from the white noise
};

/// `biases`: accelerometer [m/s^2], gyroscope [rad/s].
Preintegration preintegrate(const std::vector<ImuInterval>& intervals, const Vector6d& biases,
                            const ImuNoise& noise);

/// Repeats the integration with other biases. The mean is exact; the derivatives and Q are not
/// updated.
void set_biases(const std::vector<ImuInterval>& intervals, const Vector6d& biases,
                Preintegration& p);

/// The state moved by a preintegration with `gravity` [m/s^2], and F = d next / d (rotation,
/// position, velocity, biases of the state).
InertialState moved(const InertialState& state, const Preintegration& p,
                    const Eigen::Vector3d& gravity);
Eigen::Matrix<double, 9, 15> d_moved(const InertialState& state, const Preintegration& p);

}  // namespace chasles
