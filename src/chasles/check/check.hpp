#pragma once

#include <chasles/check/check_report.hpp>
#include <chasles/data/recording.hpp>

namespace chasles {

/// Looks at a recording before a filter does: stamps of IMU, frames and images; exposure; what the
/// accelerometer says of gravity; and whether calibration, clocks and units agree with how the
/// cameras turned, as the tracks show it.
CheckReport check_recording(const Recording& recording);

/// The same with `tracks` instead of the recording's own: those that a front end made of its
/// images.
CheckReport check_recording(const Recording& recording, const std::vector<FeatureFrame>& tracks);

/// The worst severity among the findings is an error.
bool has_error(const CheckReport& report);

}  // namespace chasles
