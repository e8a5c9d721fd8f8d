#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/imu/strapdown.hpp>

namespace chasles {

using Matrix9d = Eigen::Matrix<double, 9, 9>;

/// The motion between two keyframes that the samples tell by themselves, without gravity, from
/// identity and rest, in the axes of the first: the exact strapdown map commutes with the pose it
/// starts from, so that
///   R+ = R dR,  v+ = v + g t + R dv,  p+ = p + v t + g t^2 / 2 + R dp
/// (Forster, Carlone, Dellaert & Scaramuzza 2017, for the idea).
struct Preintegration {
  double seconds = 0;
  InertialState delta;                 ///< dR, dp, dv, at the biases that it holds
  Eigen::Matrix<double, 9, 6> d_bias;  ///< d [rotation, position, velocity] / d biases, there
  Matrix9d Q = Matrix9d::Zero();       ///< of the white noise
};

/// `biases`: accelerometer, gyroscope.
Preintegration preintegrate(const std::vector<ImuInterval>& intervals, const Vector6d& biases,
                            const ImuNoise& noise);

/// The same with other biases: the mean exactly, the derivatives and Q as they were.
void set_biases(const std::vector<ImuInterval>& intervals, const Vector6d& biases,
                Preintegration& p);

/// A state moved by it, and F = d next / d (state's rotation, position, velocity, biases).
InertialState moved(const InertialState& state, const Preintegration& p,
                    const Eigen::Vector3d& gravity);
Eigen::Matrix<double, 9, 15> d_moved(const InertialState& state, const Preintegration& p);

}  // namespace chasles
