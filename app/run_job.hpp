#pragma once

#include <functional>
#include <memory>

#include <nlohmann/json.hpp>

#include <chasles/pipeline/estimator.hpp>
#include <chasles/pipeline/shared_map.hpp>
#include <chasles/recording/recording.hpp>

#include "live_view.hpp"
#include "run_command_options.hpp"
#include "run_recording.hpp"

namespace chasles::app {

/// What a run leaves.
struct CompletedRun {
  RecordedRun result;
  nlohmann::ordered_json summary = {};  ///< content of summary.json, without `files`
  std::unique_ptr<Estimator> estimator = {};
  std::unique_ptr<SharedMap> map = {};  ///< in which it looked for its place; none: null
};

/// The run that is left to do, once. It ends early where `stop` returns true, from any thread.
using PlannedRun = std::function<CompletedRun(const StopRequest& stop, LiveView& live)>;

/// Checks options and settings for a run of this recording, as the command and the Python module
/// make it. Settings of the reader read it again, by the options. Options and recording must
/// outlive the run, which adds remarks to the recording. Throws UsageError; the run throws as
/// run_recording(), and for one without an estimate says what a check of the recording finds.
PlannedRun plan_run(const RunCommandOptions& options, Recording& recording);

}  // namespace chasles::app
