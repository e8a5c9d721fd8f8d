#pragma once

#include <chasles/slam/inertial_session.hpp>
#include <chasles/smooth/batch/batch.hpp>

namespace chasles {

/// Throws UsageError for settings that batch estimation and windows do not support: calibration.
void check_smoothing(const InertialSlamSettings& settings);

/// The input of batch estimation and windows: sensors, noise and chart of the filter's settings,
/// and the start. Samples, frames and initial states are empty. Throws as check_smoothing().
InertialBatchInput batch_input(const InertialSensors& sensors, const InertialSlamSettings& settings,
                               const InertialStart& start);

/// A filter's estimate as a start; it does not depend on any landmark yet.
InertialStart start_at(const Estimate& e);

/// A filter's estimate as an initial state of batch estimation.
TimedMotion timed_motion(const Estimate& e);

}  // namespace chasles
