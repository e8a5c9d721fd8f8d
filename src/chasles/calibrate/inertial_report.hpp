#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/calibrate/cross_validation.hpp>
#include <chasles/calibrate/inertial_halves.hpp>

namespace chasles {

/// A calibration of cameras with their IMU, with all that is said of it.
struct InertialReport {
  InertialCalibrationInput input;  ///< without lenses
  InertialCalibration calibration;
  std::optional<InertialHalves> halves;            ///< none: a half is too short, see `remarks`
  std::vector<std::optional<LensChoice>> choices;  ///< of each camera; none: its lens was given
  std::vector<double> rms_before;  ///< of each camera with the lens that it states [px]; NaN: none
  std::vector<std::string> suspicious;  ///< views that the others contradict
  std::vector<std::string> missing;     ///< which motion and views would make the result better
  std::vector<std::string> remarks;
};

/// Calibrates the rig of `report.input`, and fills all the rest; remarks that are there stay.
/// `candidates`: of each camera its lens, or those of which the best is chosen. `from_nothing`: the
/// search does not begin at the lens that a camera states. The result does not depend on the number
/// of threads. Throws as calibrate_inertial() and choose_lenses().
void calibrate_with_report(InertialReport& report,
                           const std::vector<std::vector<LensForm>>& candidates, bool from_nothing,
                           int threads = 1);

/// Which motion would make the result better: turns about an axis that hardly turned, shifts along
/// one that hardly moved.
std::vector<std::string> missing_motion(const InertialCalibrationInput& input,
                                        const InertialCalibration& calibration);

/// What contradicts the result: residuals of the IMU far above its noise, as those of a target of
/// another size.
std::vector<std::string> contradictions(const InertialCalibration& calibration);

/// A sentence on each camera whose lens is another one with the IMU than by its views alone: more
/// than three of the latter's sigmas in a parameter. It names a lens that predicts held-out views
/// better by 1 % or more, if there is one. None of rolling shutters, of which the views alone have
/// no motion.
std::vector<std::string> lens_contradictions(const InertialReport& report, int threads = 1);

/// The content of imu-cameras.json (docs/calibration.md).
nlohmann::ordered_json inertial_json(const InertialReport& report);
/// Settings with which a run counts the uncertainty of this calibration (`chasles run --config`):
/// its parts as considered states, with the largest sigma of each kind, of a lens that of its first
/// coefficient.
std::string run_settings(const InertialCalibration& calibration);
/// The table of the terminal.
std::string inertial_text(const InertialReport& report);

}  // namespace chasles
