#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/calibrate/inertial_report.hpp>
#include <chasles/calibration/foreign_writers.hpp>

namespace chasles {

/// A calibration with what was found in the place of what it states. `time_offsets` [s]: of each
/// camera, after the stated ones. `imu` corrects samples that the stated intrinsics corrected; with
/// zeros they stay.
CalibrationToWrite with_found(CalibrationToWrite stated, const std::vector<Camera>& cameras,
                              const std::vector<double>& time_offsets, const ImuCorrection& imu);

/// Throws InputError, with the names, where what corrects clocks and samples before they are read
/// is not the same in two recordings of a rig: time offsets, intrinsics of the IMU, and whether its
/// samples are means.
void check_same_rig(const std::string& first, const CalibrationToWrite& of_first,
                    const std::string& other, const CalibrationToWrite& of_other);

/// Writes into the folder, by what the recording states: the files of all programs, run.yaml and
/// imu-cameras.json. What a program's files have no room for joins the remarks. Throws as
/// write_all().
void write_inertial(InertialReport& report, const CalibrationToWrite& stated,
                    const std::filesystem::path& folder);

}  // namespace chasles
