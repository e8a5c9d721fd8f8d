#pragma once

#include <chasles/check/check_report.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// Checks a recording before a filter runs: time stamps of IMU, frames and images; exposure; the
/// gravity that the accelerometer measures; and whether calibration, clocks and units agree with
/// the rotation of the cameras, which the tracks determine.
CheckReport check_recording(const Recording& recording);

/// The same with `tracks`, from a front end, instead of the recording's own tracks.
CheckReport check_recording(const Recording& recording, const std::vector<FeatureFrame>& tracks);

/// Whether any finding is an error.
bool has_error(const CheckReport& report);

}  // namespace chasles
