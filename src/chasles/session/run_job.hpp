#pragma once

#include <functional>
#include <memory>

#include <nlohmann/json.hpp>

#include <chasles/pipeline/run.hpp>
#include <chasles/pipeline/shared_map.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/session/estimator_plan.hpp>
#include <chasles/session/run_recorder.hpp>
#include <chasles/session/session_options.hpp>

namespace chasles {

/// What a run leaves.
struct CompletedRun {
  RecordedRun result;
  nlohmann::ordered_json summary = {};  ///< content of summary.json, without `files`
  /// Only for options that need it: a saved map, the full covariance.
  std::unique_ptr<Estimator> estimator = {};
  std::unique_ptr<SharedMap> map = {};  ///< in which it looked for its place; none: null
};

/// A run before its first frame: the estimator is made, and viewers can begin.
class PreparedRun {
 public:
  /// Options and recording must outlive it.
  PreparedRun(const SessionOptions& options, Recording& recording, PreparedEstimator prepared,
              StopRequest stop);

  /// What a viewer shows of the run, before and during it. At each call of the viewer it has what
  /// that call is about.
  const RunRecorder& recorder() const { return *recorder_; }
  /// The part of summary.json that is known before the run.
  const nlohmann::ordered_json& known() const { return prepared_.known; }

  /// Runs the estimator over the recording, once. Draws the progress bar and keeps images; `viewer`
  /// follows. Adds remarks to the recording, and gives up its tracks (TrackRelease). Throws as
  /// run() of pipeline/run.hpp; for a run without an estimate it says what a check of the recording
  /// finds.
  CompletedRun run(RunObserver& viewer);

 private:
  RecordedRun record(RunObserver& viewer);
  RecordedRun record_or_diagnose(RunObserver& viewer);

  const SessionOptions& options_;
  Recording& recording_;
  PreparedEstimator prepared_;
  StopRequest stop_;
  std::unique_ptr<RunRecorder> recorder_;  ///< stays where it is when this is moved
};

/// The run that is left to prepare, once. It ends early where `stop` returns true, from any thread.
using PlannedRun = std::function<PreparedRun(const StopRequest& stop)>;

/// Checks options and settings for a run of this recording, as the command and the Python module
/// make it. Settings of the reader read it again, by the options. Options and recording must
/// outlive the run, which adds remarks to the recording and gives up its tracks and IMU samples.
/// Throws UsageError.
PlannedRun plan_run(const SessionOptions& options, Recording& recording);

}  // namespace chasles
