#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/calibration/imu_intrinsics.hpp>
#include <chasles/camera/camera.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// A calibration for the files of all programs.
struct CalibrationToWrite {
  std::string name;
  /// Without an IMU, cam_T_imu is cam_T_cam0, and the identity for the first camera.
  std::vector<Camera> cameras = {};
  /// Of each camera: its clock + offset = the IMU's clock [s]. Empty: zeros.
  std::vector<double> time_offsets = {};
  bool has_imu = false;
  ImuConvention imu_convention = ImuConvention::kInstant;
  std::optional<ImuNoise> imu_noise = {};
  ImuRange imu_range = {};
  double imu_rate = 0;  ///< of the samples [Hz]; 0: not known
  std::optional<ImuIntrinsics> imu_intrinsics = {};
  std::vector<std::string> camera_topics = {};  ///< of ROS; empty where not known
  std::string imu_topic = {};                   ///< likewise
  std::string remark = {};  ///< on the origin, which each file repeats; may have several lines
};

/// A file's name below the folder of a calibration, and its text.
struct CalibrationFile {
  std::filesystem::path name;
  std::string text;
};

/// The files of one format, and a sentence on each part of the calibration that it has no room for.
struct CalibrationFiles {
  std::vector<CalibrationFile> files = {};
  std::vector<std::string> left_out = {};
};

// One format each (docs/calibration-conventions.md). Each file states its conventions in a remark
// that its readers ignore. Throws InputError for a lens that the format does not have, with what to
// do.

/// calibration.yaml of the project.
CalibrationFiles own_calibration_files(const CalibrationToWrite& calibration);

/// Kalibr's camchain-imucam.yaml and imu.yaml, as its tools read them: each number has a decimal
/// point, without which PyYAML reads 1e-05 as a text. Without an IMU: camchain.yaml.
CalibrationFiles kalibr_files(const CalibrationToWrite& calibration);

/// camN.yaml of ROS's camera_info_manager and camera_calibration, as sensor_msgs/CameraInfo.
CalibrationFiles ros_files(const CalibrationToWrite& calibration);

/// camN.yaml of OpenCV's FileStorage: cameraMatrix and distCoeffs, for the functions that `model`
/// names: cv::projectPoints (pinhole), cv::fisheye (fisheye), cv::omnidir (omnidir, with xi). `R`
/// and `T` map the first camera's coordinates to those of this one, as those of
/// cv::stereoCalibrate.
CalibrationFiles opencv_files(const CalibrationToWrite& calibration);

/// Basalt's calibration.json.
CalibrationFiles basalt_files(const CalibrationToWrite& calibration);

/// COLMAP's cameras.txt.
CalibrationFiles colmap_files(const CalibrationToWrite& calibration);

/// What write_all() did.
struct WrittenCalibration {
  std::vector<std::filesystem::path> files = {};  ///< with the folder
  std::vector<std::string> left_out = {};         ///< a sentence on each format or part
};

/// Writes every format that has the lenses, over earlier files of these names. Throws InputError
/// for a calibration without cameras, with numbers that are not finite or with time offsets for
/// another number of cameras; UsageError if a file cannot be written.
WrittenCalibration write_all(const CalibrationToWrite& calibration,
                             const std::filesystem::path& folder);

}  // namespace chasles
