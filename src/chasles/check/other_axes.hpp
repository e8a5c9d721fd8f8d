#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

struct CameraFit;

/// The axes of an IMU's samples where they are not those that a recording states.
struct OtherAxes {
  /// Of the gyroscope's axes, as CameraFit::signs.
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  /// From the stated axes of the IMU to those of its samples: a rotation by quarter turns.
  Eigen::Matrix3d imu_R_stated = Eigen::Matrix3d::Identity();
  double rest = 0;            ///< what the turn leaves of the camera's rotation against it [rad]
  bool of_gyroscope = false;  ///< of its samples alone: those of the accelerometer are as stated

  bool has_signs() const { return signs.minCoeff() < 0; }
  bool has_turn() const { return !imu_R_stated.isIdentity(); }
  /// The gyroscope's axes with another sign, as "x, z".
  std::string mirrored() const;
  /// What the samples have where the extrinsics state x, y, z: as "x, -y, -z".
  std::string turned() const;
};

/// What a fit shows of them; `camera`: the one that was fitted, as it is stated. Nothing where the
/// axes are the stated ones, where the images do not rotate as the gyroscope measures, where the
/// rotation of the camera is uncertain by more than 2 degrees, or where it is more than 10 degrees
/// from each turn onto other axes.
std::optional<OtherAxes> other_axes(const CameraFit& fit, const Camera& camera);

/// The axes with which gyroscope and accelerometer agree: along the path, gravity keeps its
/// direction. A turn is that of both, or of the gyroscope alone; signs are the gyroscope's. Nothing
/// where they do not agree either way.
std::optional<OtherAxes> agreeing_with_gravity(OtherAxes axes, const std::vector<ImuSample>& imu);

/// The samples in the stated axes.
void take_axes(const OtherAxes& axes, std::vector<ImuSample>& imu);

}  // namespace chasles
