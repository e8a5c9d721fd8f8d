#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/imu/strapdown.hpp>

namespace chasles {

/// Scales, misalignments and g-sensitivity of an IMU as random constants: what the intrinsics of
/// its calibration (calibration/imu_intrinsics.hpp), which are undone before, leave. In the same
/// sense they correct samples f_m, w_m:
///   f = (I + A) f_m,   w = (I + W) w_m - S f.
/// The biases and the noise are those of the corrected samples. A is lower triangular: the IMU's x
/// axis is that of the accelerometer, and its y axis lies in the plane of the accelerometer's x and
/// y. Without that, A and the extrinsics of all cameras could turn together. The gyroscope's W is a
/// full matrix, since its axes may be turned against the accelerometer's (Rehder et al. 2016).
///
/// The parameters, of which a state has those of some groups:
///   scale: the diagonals of A and of W [1];
///   misalignment: A yx, zx, zy, and W xy, xz, yx, yz, zx, zy (row, column) [rad];
///   g-sensitivity: S by rows [rad/s / (m/s^2)].
struct ImuCorrection {
  static constexpr int kScales = 6, kMisalignments = 9, kGSensitivities = 9;
  static constexpr int kMost = kScales + kMisalignments + kGSensitivities;
  using Parameters = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;
  /// Rows: specific force, angular rate.
  using Derivative = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMost>;

  Eigen::Matrix3d force = Eigen::Matrix3d::Zero();                           ///< A
  Eigen::Matrix3d rate = Eigen::Matrix3d::Zero();                            ///< W
  Eigen::Matrix3d rate_of_force = Eigen::Matrix3d::Zero();                   ///< S
  bool has_scale = true, has_misalignment = true, has_g_sensitivity = true;  ///< else known

  int size() const {
    return (has_scale ? kScales : 0) + (has_misalignment ? kMisalignments : 0) +
           (has_g_sensitivity ? kGSensitivities : 0);
  }
  Parameters parameters() const;
  /// Replaces the parameters that it has; size() rows, as parameters().
  void set(const Eigen::Ref<const Eigen::VectorXd>& parameters);
  /// Adds errors to the parameters; `errors` has size() rows.
  void add(const Eigen::Ref<const Eigen::VectorXd>& errors);
  /// As "accelerometer_scale_x", "gyroscope_misalignment_x_y" (row, column), "g_sensitivity_z_x".
  std::vector<std::string> names() const;

  /// d (f, w) / d parameters at a measured sample.
  Derivative derivative(const Eigen::Vector3d& force_measured,
                        const Eigen::Vector3d& rate_measured) const;
};

/// What the IMU would have measured without the errors.
ImuInterval corrected(const ImuCorrection& correction, ImuInterval interval);
ImuSample corrected(const ImuCorrection& correction, ImuSample sample);
/// The same; a sample that is saturated as measured is marked (ImuSample::force_clipped).
ImuSample corrected(const ImuCorrection& correction, const ImuRange& measured, ImuSample sample);

}  // namespace chasles
