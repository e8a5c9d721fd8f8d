#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/eval/truth_examination.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/session/coverage.hpp>
#include <chasles/session/realtime.hpp>
#include <chasles/session/session_observer.hpp>

namespace chasles {

/// Options of run_recording().
struct RunRecordingOptions {
  EstimatorChoice estimator = {};  ///< kind of the given estimator
  FrontendSettings frontend = {};
  RunOptions run = {};
  int frames_per_estimate = 1;          ///< above 1 for a window with fewer keyframes than frames
  bool quiet = false;                   ///< no progress bar
  std::optional<int> keep_images = {};  ///< as for ImageKeeper
  bool truth_is_comparable = true;      ///< during the run: it has attitudes and the right clock
  /// For a run that started at the truth: the chart of nees_state.
  std::optional<std::string> truth_chart = {};
  /// Columns of states.csv after those of the estimator (calibration_report.hpp).
  std::vector<std::string> calibration_columns = {};
  Trajectory dead_reckoning = {};           ///< for viewers and the page
  nlohmann::ordered_json known = {};        ///< part of summary.json known before the run
  std::optional<MapSketch> prior_map = {};  ///< in which the estimator looks for its place
};

/// Results of an estimator on a recording.
struct RecordedRun {
  Run run;
  RunReport report;
  std::optional<double> start_seconds;  ///< from the first frame to the first estimate [s]
  /// From the first frame to that which completed the first estimate [s].
  std::optional<double> initialised_seconds;
  FrameCoverage coverage;
  int zupt_frames = 0;                      ///< frames with a zero-velocity update
  std::map<Degradation, int> degradations;  ///< numbers of degraded frames, by their reasons
  std::optional<double> nees_state;         ///< mean; if the truth has velocity and biases
  std::optional<double> innovation_correlation;
  bool truth_attitudes = true;  ///< false: the truth has positions alone
  std::vector<TruthFinding> truth_findings;
  std::optional<double> truth_tilt_deg;  ///< removed from the truth, where its world is not level
  std::optional<RealtimeFigures> realtime;
  bool has_prior_map = false;
  std::optional<Calibration> calibration;  ///< last estimate, if it is estimated
};

/// Runs the estimator over the recording until its end, or until `stop` returns true. Draws the
/// progress bar, informs the observer and keeps images. Throws as run() of pipeline/run.hpp.
RecordedRun run_recording(const Recording& recording, Estimator& estimator,
                          const RunRecordingOptions& options, const StopRequest& stop,
                          SessionObserver& observer);

/// world_T_imu at every frame, integrated from the velocities only (midpoint rule, exact
/// exponential). The pose at the first event is the identity. Ends at the first pose that is not
/// finite.
Trajectory dead_reckoning(const Recording& recording);

}  // namespace chasles
