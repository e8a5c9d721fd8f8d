#pragma once

#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/camera/camera.hpp>
#include <chasles/filter/calibration.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/slam/inertial_settings.hpp>

namespace chasles {

/// Names of the columns of states.csv for the estimated calibration. Each camera has the rotation
/// by which imu_T_cam differs from the recording's calibration (rotation vector phi, Exp(phi)
/// R_file, IMU axes [rad]), and its position in the IMU frame [m]. Then follow the time offset
/// [s], the intrinsics of each camera, and the parameters of the IMU, of what is estimated or
/// considered. Empty if no calibration is in the state.
std::vector<std::string> calibration_columns(const InertialSlamSettings& settings,
                                             std::span<const Camera> cameras);

/// Appends the values of these columns to `state`. `cameras` are those of the recording.
void append_calibration(const Calibration& calibration, std::span<const Camera> cameras,
                        RunState& state);

/// The object "calibration" of summary.json: imu_T_cam of each camera, its standard deviations, and
/// its difference from the recording's calibration; the time offset; and the table `parameters` of
/// all: stated value and sigma, estimate and sigma, and whether the motion observed it.
nlohmann::ordered_json calibration_json(const Calibration& calibration,
                                        std::span<const Camera> cameras,
                                        const InertialSlamSettings& settings);

/// One remark for parameters that the motion did not observe, and one for those whose estimate is
/// far from what was stated. The time offset has a remark of its own.
std::vector<std::string> calibration_remarks(const Calibration& calibration,
                                             std::span<const Camera> cameras,
                                             const InertialSlamSettings& settings);

}  // namespace chasles
