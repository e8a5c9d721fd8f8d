#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/codec/yaml_map.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// Scales, misalignments and g-sensitivity of an IMU, as the correction of its samples f_m, w_m:
///   f = force f_m - force_bias,   w = rate w_m - rate_of_force f - rate_bias.
/// The biases that are estimated are those of the corrected samples.
struct ImuIntrinsics {
  Eigen::Matrix3d force = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d rate = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d rate_of_force = Eigen::Matrix3d::Zero();  ///< [rad/s / (m/s^2)]
  Eigen::Vector3d force_bias = Eigen::Vector3d::Zero();     ///< [m/s^2]
  Eigen::Vector3d rate_bias = Eigen::Vector3d::Zero();      ///< [rad/s]
};

/// The intrinsics of an IMU's calibration file; none where they are missing or the identity.
///
/// Kalibr (Rehder et al. 2016), `model: scale-misalignment`, with the maps `accelerometers` (M) and
/// `gyroscopes` (M, A, C_gyro_i):
///   f_m = M f,   w_m = M C_gyro_i w + A C_gyro_i f.
/// OpenVINS (Yang et al. 2023), keys Ta, R_IMUtoACC, Tw, R_IMUtoGYRO, Tg:
///   f_m = Ta R_IMUtoACC f,   w_m = Tw R_IMUtoGYRO w + Tg f.
///
/// Adds a remark for the lever arms of Kalibr's scale-misalignment-size-effect, which a single
/// sample cannot be corrected for. Throws InputError for a matrix that has no inverse or is a
/// reflection, and for a g-sensitivity (A, Tg) that no gyroscope has, as the identity.
std::optional<ImuIntrinsics> read_imu_intrinsics(const YamlMap& map,
                                                 std::vector<std::string>& remarks);

/// A sample corrected. Where it is at the limit of the sensor's range, it is marked
/// (ImuSample::force_clipped).
ImuSample corrected(const ImuIntrinsics& intrinsics, const ImuRange& measured, ImuSample sample);
/// A range that no corrected sample reaches, except those that are marked. `force_on_rate`: the
/// largest change of a rate by the force [rad/s].
ImuRange corrected_range(const ImuIntrinsics& intrinsics, const ImuRange& measured,
                         double force_on_rate);

}  // namespace chasles
