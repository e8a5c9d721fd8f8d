#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/imu/body_velocity.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// The content of calibration.yaml of a recording folder (docs/formats.md).
struct FolderCalibration {
  std::string name;
  std::optional<StereoRig> rig = {};
  std::vector<Camera> cameras = {};
  /// Of each camera: added to the stamps of its images, it gives the IMU's clock. Zeros and none
  /// are not written.
  std::vector<Time> time_offsets = {};
  std::optional<ImuConvention> imu_convention = {};  ///< where there is an IMU
  std::vector<std::string> remarks = {};
  /// Standard deviations, where the recording states them (Recording).
  std::optional<BodyVelocitySigma> velocity_sigma = {};
  std::optional<Eigen::Vector4d> pixel_sigma = {};
  std::optional<double> single_pixel_sigma = {};
  std::optional<ImuNoise> imu_noise = {};
  ImuRange imu_range = {};
  std::optional<bool> truth_level = {};  ///< as in Recording
};

/// Throws InputError with file and line for an unknown, missing, repeated or malformed key.
FolderCalibration read_calibration(const std::filesystem::path& file);
/// The text of that file.
std::string calibration_text(const FolderCalibration& calibration);
void write_calibration(const FolderCalibration& calibration, const std::filesystem::path& file);

}  // namespace chasles
