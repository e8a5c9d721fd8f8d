#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/recording/recording.hpp>

namespace chasles {

/// Tables of an accelerometer and of a gyroscope apart, as phone apps and scripts write them.
struct SensorTables {
  std::optional<std::filesystem::path> accelerometer, gyroscope;
  std::vector<std::string> remarks = {};  ///< on tables that are not taken
};

/// Finds the tables in a folder by their names, in small or capital letters, as .csv, .txt or .tsv:
/// gyro, gyroscope, … and accel, accelerometer, TotalAcceleration, … A `0` may follow. Of several
/// the first of docs/formats.md counts: those with gravity, those that an app has corrected.
SensorTables find_sensor_tables(const std::filesystem::path& folder);

/// Whether there is one of either.
bool has_sensor_tables(const std::filesystem::path& folder);

/// Reads the two tables and joins them (join_streams()) to recording.imu.
///
/// They are tables as those of an IMU (imu_table.hpp): the same names of times, separators, units
/// and times. The axes are the only three columns that differ in x, y and z (find_sensor_axes()).
///
/// Throws InputError: with file, line and column as read_imu_table(); for one table without the
/// other; for an accelerometer whose median shows no gravity; and as join_streams().
void read_sensor_tables(const SensorTables& tables, const std::filesystem::path& folder,
                        Recording& recording);

}  // namespace chasles
