#pragma once

#include <chasles/recording/recording.hpp>
#include <chasles/session/recorded_run.hpp>
#include <chasles/session/truth_options.hpp>

namespace chasles {

/// Examines the truth with the estimate, and applies what the options leave to that: an offset, a
/// point on the body, and the tilt of a world that is not level, with what else is in that world.
/// Adds remarks to the recording. Without truth or states it does nothing.
void prepare_truth_of_run(const TruthOptions& options, Recording& recording, RecordedRun& result);

}  // namespace chasles
