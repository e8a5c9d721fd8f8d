#pragma once

#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/camera/camera.hpp>
#include <chasles/filter/calibration.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/slam/inertial_settings.hpp>

namespace chasles::app {

/// Names of the columns of states.csv for the estimated calibration. Each camera has the rotation
/// by which imu_T_cam differs from the recording's calibration (rotation vector phi, Exp(phi)
/// R_file, IMU axes [rad]), and its position in the IMU frame [m]. Then follows the time offset
/// [s]. Empty if no calibration is estimated.
std::vector<std::string> calibration_columns(const InertialSlamSettings& settings,
                                             std::size_t cameras);

/// Appends the values of these columns to `state`. `cameras` are those of the recording.
void append_calibration(const Calibration& calibration, std::span<const Camera> cameras,
                        RunState& state);

/// The object "calibration" of summary.json: imu_T_cam of each camera, its standard deviations, and
/// its difference from the recording's calibration. `stated_time_offset` is the setting's [s].
nlohmann::ordered_json calibration_json(const Calibration& calibration,
                                        std::span<const Camera> cameras, double stated_time_offset);

}  // namespace chasles::app
