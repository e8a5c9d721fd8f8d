#pragma once

#include <vector>

#include <chasles/lab/trial.hpp>
#include <chasles/pipeline/batch_input.hpp>
#include <chasles/smooth/window/inertial_window.hpp>

namespace chasles {

/// The input of batch estimation from a recording of tracks, with the noise, chart and start of a
/// filter's settings, without initial states.
InertialBatchInput batch_input(const Recording& recording, const InertialSlamSettings& settings,
                               const InertialStart& start);

/// Batch estimation over a recording with truth, as run_trial(): one point per keyframe.
struct BatchTrial {
  Trial trial;
  BatchReport report;
};
BatchTrial run_batch_trial(const FilterVariant& filter, const BatchSettings& settings,
                           const Recording& recording, const InertialStart& start,
                           std::vector<TimedMotion> initial);

/// A window over a recording with truth, as run_trial(): one point per keyframe.
Trial run_window_trial(const FilterVariant& filter, const BatchSettings& settings,
                       const Recording& recording, const InertialStart& start);

/// The filter's estimates, as initial values of batch estimation.
std::vector<TimedMotion> filter_motions(const FilterVariant& filter, const Recording& recording,
                                        const InertialStart& start);

}  // namespace chasles
