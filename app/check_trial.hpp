#pragma once

#include <vector>

#include <chasles/check/check_report.hpp>
#include <chasles/data/recording.hpp>

namespace chasles::app {

/// Runs the filter, with default settings, over the tracks of the first camera in `frames`, so that
/// the check knows what a run knows. A fact: the share of the frames with an estimate. Where the
/// filter does not start, or doubts its estimates, a finding with the reason; it names a wrong
/// sign, axis or unit of the IMU with which the filter works. Does nothing without an IMU, its
/// noise, or a camera.
void report_trial(const Recording& recording, const std::vector<FeatureFrame>& frames,
                  CheckReport& report);

}  // namespace chasles::app
