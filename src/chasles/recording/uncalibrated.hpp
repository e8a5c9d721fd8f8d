#pragma once

#include <filesystem>
#include <optional>

#include <chasles/recording/recording.hpp>

namespace chasles {

/// Whether a folder has images with an IMU's table or their times, as a folder of images or of
/// EuRoC's form has them, but no calibration of any program: what is recorded to be calibrated.
bool is_uncalibrated(const std::filesystem::path& folder);

/// Such a recording: the cameras of cam0, cam1, … with the sizes of their first images alone
/// (fx = 0), and times as image_times.hpp. The noise of the IMU is that of imu0/sensor.yaml or of
/// Kalibr's imu.yaml; none without them, and no
/// samples without a table. Throws InputError as the readers of images and tables.
Recording read_uncalibrated(const std::filesystem::path& folder);

/// The table of the IMU of such a folder; none without one. Throws InputError for several.
std::optional<std::filesystem::path> imu_table_of(const std::filesystem::path& folder);

}  // namespace chasles
