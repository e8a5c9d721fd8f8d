#pragma once

#include <functional>
#include <memory>

#include <nlohmann/json.hpp>

#include <chasles/pipeline/run.hpp>
#include <chasles/pipeline/shared_map.hpp>
#include <chasles/session/run_recorder.hpp>
#include <chasles/session/session_options.hpp>

namespace chasles {

/// The estimator of a run, and what its kind of run and its settings say of running and recording.
struct PreparedEstimator {
  std::unique_ptr<Estimator> estimator = {};
  std::unique_ptr<SharedMap> map = {};  ///< in which it looks for its place; none: null
  FrontendSettings frontend = {};
  RunOptions run = {};
  RunRecorder::Options recorded = {};
  nlohmann::ordered_json known = {};  ///< part of summary.json known before the run
  /// Content of summary.json, without `files`.
  std::function<nlohmann::ordered_json(const RecordedRun&)> summary = {};
};

/// Makes the estimator, once. It ends early where `stop` returns true, from any thread.
using EstimatorPlan = std::function<PreparedEstimator(const StopRequest& stop)>;

/// Checks options and settings for either kind of run, before outputs and viewers exist. Settings
/// of the reader read the recording again, by the options. Options and recording must outlive the
/// plan and what it makes, which add remarks to the recording. Throws UsageError.
EstimatorPlan plan_estimator(const SessionOptions& options, Recording& recording);

}  // namespace chasles
