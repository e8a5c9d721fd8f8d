#pragma once

#include <vector>

#include <chasles/check/check_report.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles::app {

/// The beginning of a finding's advice that names what makes the filter work.
inline constexpr const char* kCureBegins = "with ";

/// Runs the filter, with default settings, over the tracks in `frames`, so that the check knows
/// what a run knows. A fact: the share of the frames with an estimate. Where the filter does not
/// start, or reports degraded estimates, a finding with the reason. It names what makes the filter
/// work: the first camera alone, or another sign, axis or unit of the IMU. Does nothing without an
/// IMU, its noise, or a camera.
void report_trial(const Recording& recording, const std::vector<FeatureFrame>& frames,
                  CheckReport& report);

}  // namespace chasles::app
