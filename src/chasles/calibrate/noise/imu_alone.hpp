#pragma once

#include <filesystem>

#include <chasles/recording/recording.hpp>

namespace chasles {

/// Reads a recording for its IMU. Where read_recording() cannot read it, because cameras or their
/// calibration are missing, the samples alone: of a table (read_imu_table()), of a folder's only
/// table or its tables of accelerometer and gyroscope, or of the only topic of a bag that has both
/// (sensor_msgs/Imu). A remark says so. Throws the InputError of read_recording() where there are
/// no such samples, and one that names the topics where a bag has several.
Recording read_for_imu(const std::filesystem::path& path);

}  // namespace chasles
