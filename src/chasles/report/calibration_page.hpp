#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

namespace chasles {

/// What one camera saw of the target at an instant, for the page.
struct CalibrationView {
  double seconds = 0;  ///< since any epoch
  int camera = 0;
  bool is_suspicious = false;
  double rms = 0;                               ///< of its errors [px]
  std::vector<Eigen::Vector2d> pixels, errors;  ///< of its corners: measured; minus projected [px]
};

/// One self-contained HTML page that loads nothing: what a calibration of cameras found, and how
/// good it is. `calibration`: the content of cameras.json. All corners count in the figures; of
/// those that are drawn one by one there are a few thousand for each camera. The same arguments
/// give the same bytes. Names are shown as text, whatever they contain.
std::string cameras_page(const nlohmann::ordered_json& calibration,
                         std::span<const CalibrationView> views);

/// The Allan deviation of one axis of an IMU, for the page.
struct AllanCurve {
  std::string sensor, axis;     ///< "gyroscope", "x"
  std::vector<double> seconds;  ///< tau, rising
  /// Of each tau: overlapping Allan deviation, its 95 % interval, and that of the fit, in the unit
  /// of the sensor.
  std::vector<double> deviation, lowest, highest, of_fit;
};

/// The page of a calibration of an IMU's noise. `noise`: the content of noise.json; no curves: no
/// standstill.
std::string noise_page(const nlohmann::ordered_json& noise, std::span<const AllanCurve> curves);

}  // namespace chasles
