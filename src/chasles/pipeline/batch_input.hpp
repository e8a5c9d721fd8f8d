#pragma once

#include <chasles/slam/inertial_session.hpp>
#include <chasles/smooth/batch/batch.hpp>

namespace chasles {

/// Throws UsageError for settings that batch estimation and windows do not have: calibration.
void check_smoothing(const InertialSlamSettings& settings);

/// What batch estimation and windows take: sensors, the noise and chart of the filter's settings,
/// and the start. Without samples, frames and initial states. Throws as check_smoothing().
InertialBatchInput batch_input(const InertialSensors& sensors, const InertialSlamSettings& settings,
                               const InertialStart& start);

/// A filter's estimate as a start for what begins there: no landmark is a part of it yet.
InertialStart start_at(const Estimate& e);

/// The same as a state where the search of batch estimation begins.
TimedMotion timed_motion(const Estimate& e);

}  // namespace chasles
