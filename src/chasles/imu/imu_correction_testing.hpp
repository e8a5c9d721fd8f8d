#pragma once

#include <Eigen/LU>

#include <chasles/imu/imu_correction.hpp>

/// Included by tests only.
namespace chasles::test {

/// What an IMU with these errors measures of a sample: the inverse of corrected().
inline ImuSample as_measured(const ImuCorrection& errors, ImuSample sample) {
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const Eigen::Vector3d rate =
      sample.angular_rate_imu + errors.rate_of_force * sample.specific_force_imu;
  sample.specific_force_imu = (I + errors.force).inverse() * sample.specific_force_imu;
  sample.angular_rate_imu = (I + errors.rate).inverse() * rate;
  return sample;
}

}  // namespace chasles::test
