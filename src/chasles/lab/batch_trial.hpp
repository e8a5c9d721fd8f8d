#pragma once

#include <vector>

#include <chasles/lab/trial.hpp>
#include <chasles/smooth/window/inertial_window.hpp>

namespace chasles {

/// Throws UsageError for settings that batch estimation and windows do not have: calibration.
void check_smoothing(const InertialSlamSettings& settings);

/// What batch estimation takes from a recording, with the noise, chart and start of a filter's
/// settings; no initial states. Throws as check_smoothing().
InertialBatchInput batch_input(const Recording& recording, const InertialSlamSettings& settings,
                               const InertialStart& start);

/// A keyframe's estimate, as the filter would have said it.
InertialEstimate estimate_of(const BatchMotion& motion);
InertialEstimate estimate_of(const WindowMotion& motion);

/// The other way round: where batch estimation may begin.
TimedMotion timed_motion(const InertialEstimate& e);

/// Batch estimation over a recording with truth, as run_trial: one point a keyframe.
struct BatchTrial {
  Trial trial;
  BatchReport report;
};
BatchTrial run_batch_trial(const FilterVariant& filter, const BatchSettings& settings,
                           const Recording& recording, const InertialStart& start,
                           std::vector<TimedMotion> initial);

/// A window over a recording with truth, as run_trial: one point a keyframe.
Trial run_window_trial(const FilterVariant& filter, const BatchSettings& settings,
                       const Recording& recording, const InertialStart& start);

/// The filter's own estimates, where batch estimation may begin.
std::vector<TimedMotion> filter_motions(const FilterVariant& filter, const Recording& recording,
                                        const InertialStart& start);

}  // namespace chasles
