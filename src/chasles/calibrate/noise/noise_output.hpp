#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/calibrate/noise/noise_calibration.hpp>

namespace chasles {

/// All numbers of the calibration, by name and with their units (docs/calibration.md). What is not
/// shown is null.
nlohmann::ordered_json noise_json(const NoiseCalibration& calibration);

/// A table for a terminal.
std::string noise_text(const NoiseCalibration& calibration);

/// The keys of an imu.yaml of Kalibr, which are those of calibration.yaml too, with comments on
/// what is a limit. A walk that nothing shows is a comment, and a reader then names the missing
/// key.
std::string noise_yaml(const NoiseCalibration& calibration);

/// The Allan deviations as a table: axis,tau_s,deviation,low,high,fit,dof,differences, one row for
/// each point. No rows without a standstill.
std::string allan_csv(const NoiseCalibration& calibration);

}  // namespace chasles
