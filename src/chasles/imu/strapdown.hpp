#pragma once

#include <Eigen/Core>

#include <chasles/imu/imu_sample.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

using Matrix15d = Eigen::Matrix<double, 15, 15>;

/// The state that IMU samples propagate: pose, velocity and the biases of the IMU.
struct InertialState {
  SE3 world_T_imu;
  Eigen::Vector3d v_world = Eigen::Vector3d::Zero();             ///< [m/s]
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  ///< [m/s^2]
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();      ///< [rad/s]

  Vector6d biases() const {  ///< accelerometer's, gyroscope's
    return (Vector6d() << accelerometer_bias, gyroscope_bias).finished();
  }
};

/// Specific force and angular rate, constant in IMU axes over an interval.
struct ImuInterval {
  double tau = 0;                                                ///< [s]
  Eigen::Vector3d specific_force_imu = Eigen::Vector3d::Zero();  ///< as measured [m/s^2]
  Eigen::Vector3d angular_rate_imu = Eigen::Vector3d::Zero();    ///< as measured [rad/s]
  double noise_scale = 1;  ///< factor on the variance of the white noise: above 1 where samples are
                           ///< missing (imu_buffer.hpp)
  /// Additional white-noise densities, where a sample was saturated.
  double accelerometer_extra_density = 0;  ///< [m/s^2/sqrt(Hz)]
  double gyroscope_extra_density = 0;      ///< [rad/s/sqrt(Hz)]
};

/// A step and its exact linearisation in the reference chart: d next = F d now + d_gravity dg +
/// noise of covariance Q. The error is d = [rotation; position; velocity; accelerometer bias;
/// gyroscope bias]. The rotation error is R = Exp(theta) Rhat in world axes; all other errors are
/// additive.
struct StrapdownStep {
  InertialState state;
  Matrix15d F = Matrix15d::Identity();
  Matrix15d Q = Matrix15d::Zero();
  Eigen::Matrix<double, 15, 3> d_gravity = Eigen::Matrix<double, 15, 3>::Zero();
};

/// The exact integral over an interval (docs/derivations.md, D29). With f and w the specific force
/// and rate without bias,
///   R+ = R Exp(w tau),  v+ = v + R Jl(w tau) f tau + g tau,  p+ = p + v tau + R Gamma2(w tau) f
///   tau^2 + g tau^2 / 2.
/// F and d_gravity are the exact derivatives of this map. Q contains the white noise of both
/// sensors and the random walks of the biases, the latter on the biases only. The white noise is
/// constant over the interval, as the sample is. Its standard deviation is density / sqrt(tau), so
/// that an interval may be split in two. density^2 is noise_scale times the sensor's density^2 plus
/// the extra density^2. tau = 0: the state is unchanged.
StrapdownStep strapdown(const InertialState& state, const ImuInterval& interval,
                        const Eigen::Vector3d& gravity_world, const ImuNoise& noise);

/// The mean alone.
InertialState integrate(const InertialState& state, const ImuInterval& interval,
                        const Eigen::Vector3d& gravity_world);

}  // namespace chasles
