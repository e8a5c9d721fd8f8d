#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/calibration/imu_intrinsics.hpp>
#include <chasles/camera/camera.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/recording/reader_settings.hpp>

namespace chasles {

/// The calibration of cameras and an IMU whose data come from drivers, not from a recording.
struct SensorCalibration {
  std::vector<Camera> cameras = {};  ///< none: the file has that of the IMU alone
  /// For each camera: added to its stamps, it gives the IMU's clock.
  std::vector<Time> time_offsets = {};
  std::vector<std::string> camera_topics = {};  ///< of ROS; empty where the file names none
  std::string imu_topic = {};                   ///< likewise
  double imu_rate = 0;                          ///< [Hz], as the file states it; 0: it does not
  ImuConvention imu_convention = ImuConvention::kInstant;
  ImuNoise imu_noise = {};
  ImuRange imu_range = {};
  std::optional<ImuIntrinsics> imu_intrinsics = {};
  /// Of an accelerometer and a gyroscope with topics of their own: from the axes of the former to
  /// those of the latter.
  Eigen::Matrix3d gyro_R_accel = Eigen::Matrix3d::Identity();
  std::optional<double> single_pixel_sigma = {};  ///< as in Recording
  bool exact_calibration = false;                 ///< as in Recording
  std::vector<std::string> remarks = {};
};

/// Reads the calibration files that recordings have, with the same meaning:
///
/// - Kalibr's camera chain, with the IMU's file beside it, or a folder with both (find_kalibr());
/// - Kalibr's imu.yaml alone, or a folder with it: no cameras;
/// - calibration.yaml of the project's own format, or its folder;
/// - a folder in EuRoC's format: mav0, or the one above;
/// - another program's file (foreign_calibration.hpp) or a folder with it, but VINS's.
///
/// Reads the first `cameras` cameras. Throws InputError with the file, what it lacks, and what is
/// expected.
SensorCalibration read_sensor_calibration(const std::filesystem::path& path,
                                          std::size_t cameras = kAllCameras);

/// The same; none of a folder without such files, and of a file of another kind, by its name and
/// content. `imu_rate` [Hz] makes densities of the noise of VINS; 0: that is an error.
std::optional<SensorCalibration> find_sensor_calibration(const std::filesystem::path& path,
                                                         double imu_rate = 0);

/// A sample of such an IMU, corrected by its intrinsics, as correct_samples() does it.
ImuSample corrected_sample(const SensorCalibration& calibration, const ImuSample& measured);

/// The range of corrected samples. Without intrinsics that of the sensor. With them samples at the
/// limit are marked (ImuSample::force_clipped), and no other sample reaches this range.
ImuRange corrected_range(const SensorCalibration& calibration);

}  // namespace chasles
