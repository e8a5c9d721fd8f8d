#pragma once

#include <nlohmann/json_fwd.hpp>

#include <chasles/recording/recording.hpp>
#include <chasles/session/recorded_run.hpp>
#include <chasles/session/truth_options.hpp>

namespace chasles {

/// Examines the truth with the estimate, and applies what the options leave to that: an offset, a
/// point on the body, and the tilt of a world that is not level, with what else is in that world.
/// Adds remarks to the recording. Without truth or states it does nothing.
void prepare_truth_of_run(const TruthOptions& options, Recording& recording, RecordedRun& result);

/// With --truth-errors auto: adds `truth_errors` to a summary with figures, or a remark why the
/// constants cannot be estimated. After prepare_truth_of_run().
void add_truth_errors(const TruthOptions& options, const RecordedRun& result,
                      nlohmann::ordered_json& summary);

}  // namespace chasles
