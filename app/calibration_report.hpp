#pragma once

#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/camera/camera.hpp>
#include <chasles/data/run.hpp>
#include <chasles/filter/calibration.hpp>
#include <chasles/slam/inertial_settings.hpp>

namespace chasles::app {

/// The columns of states.csv that what is estimated of the sensors' arrangement has: of every
/// camera the rotation (rotation vector phi, Exp(phi) R_file, IMU axes [rad]) by which imu_T_cam
/// differs from the recording's calibration and its position [m], and the time offset [s]. Empty
/// where nothing of it is estimated.
std::vector<std::string> calibration_columns(const InertialSlamSettings& settings,
                                             std::size_t cameras);

/// Appends their numbers; `cameras` are the recording's.
void append_calibration(const Calibration& calibration, std::span<const Camera> cameras,
                        RunState& state);

/// The part of summary.json: matrices as in the recording's calibration, deviations, and how far
/// both are from the recording's.
nlohmann::ordered_json calibration_json(const Calibration& calibration,
                                        std::span<const Camera> cameras, double stated_time_offset);

}  // namespace chasles::app
