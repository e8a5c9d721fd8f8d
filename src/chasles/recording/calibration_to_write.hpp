#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/calibration/foreign_writers.hpp>

namespace chasles {

/// A calibration that was read, for the files of other programs.
struct CalibrationFound {
  CalibrationToWrite calibration;
  std::vector<std::string> remarks;  ///< of the reader
};

/// The calibration of a file or folder that read_sensor_calibration() reads, of a calibration.yaml
/// or a camera chain of Kalibr of cameras alone, or of a recording. `imu_rate` [Hz] stands in for
/// what the file states; 0: that of the file, or of the recording's samples. Throws InputError.
CalibrationFound find_calibration_to_write(const std::filesystem::path& path, double imu_rate = 0);

/// The same for what a calibration of a recording replaces: one without a calibration
/// (is_uncalibrated()) states its IMU alone, and no cameras.
CalibrationFound find_calibration_to_replace(const std::filesystem::path& recording);

}  // namespace chasles
