#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/calibrate/inertial_calibration.hpp>

namespace chasles {

/// Which motion would make the result better: turns about an axis that hardly turned, shifts along
/// one that hardly moved.
std::vector<std::string> missing_motion(const InertialCalibrationInput& input,
                                        const InertialCalibration& calibration);

/// What contradicts the result: residuals of the IMU far above its noise, as those of a target of
/// another size.
std::vector<std::string> contradictions(const InertialCalibration& calibration);

/// The content of imu-cameras.json (docs/calibration.md).
nlohmann::ordered_json inertial_json(const InertialCalibration& calibration,
                                     const std::vector<std::string>& missing,
                                     const std::vector<std::string>& remarks);
/// Settings with which a run counts the uncertainty of this calibration (`chasles run --config`):
/// its parts as considered states, with the largest sigma of each kind, of a lens that of its first
/// coefficient.
std::string run_settings(const InertialCalibration& calibration);
/// The table of the terminal.
std::string inertial_text(const InertialCalibration& calibration,
                          const std::vector<std::string>& missing,
                          const std::vector<std::string>& remarks);

}  // namespace chasles
