#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/data/recording.hpp>
#include <chasles/data/run.hpp>
#include <chasles/pipeline/run.hpp>

#include "realtime.hpp"

namespace chasles::app {

class Interrupt;
class LiveView;

/// How a recording is run.
struct RunRecordingOptions {
  EstimatorChoice estimator = {};  ///< the kind of the one that is given
  FrontendSettings frontend = {};
  RunOptions run = {};
  bool quiet = false;                   ///< no progress bar
  std::optional<int> keep_images = {};  ///< as for ImageKeeper
  /// Of a run that began at the truth: the chart of nees_state.
  std::optional<std::string> truth_chart = {};
  /// Columns of states.csv behind the estimator's own (calibration_report.hpp).
  std::vector<std::string> calibration_columns = {};
  Trajectory dead_reckoning = {};     ///< for viewers and the page
  nlohmann::ordered_json known = {};  ///< what of summary.json is known before the run
};

/// A recording after an estimator has gone through it.
struct RecordedRun {
  Run run;
  RunReport report;
  std::optional<double> start_seconds;  ///< of the first estimate, since the first frame
  int zupt_frames = 0;                  ///< with a zero-velocity update
  std::optional<double> nees_state;     ///< mean; where the truth has velocity and biases
  std::optional<double> innovation_correlation;
  std::optional<RealtimeFigures> realtime;
  std::optional<Calibration> calibration;  ///< the last estimate's, where it is estimated
};

/// Runs the estimator over the recording, until its end or an interrupt, with progress bar, live
/// view and kept images. Throws as run() of pipeline/run.hpp.
RecordedRun run_recording(const Recording& recording, Estimator& estimator,
                          const RunRecordingOptions& options, const Interrupt& interrupt,
                          LiveView& live);

/// world_T_imu at every frame from the velocities alone: the pose at the first event is the
/// identity, midpoint rule, exact exponential. Ends where it is no longer finite.
Trajectory dead_reckoning(const Recording& recording);

}  // namespace chasles::app
