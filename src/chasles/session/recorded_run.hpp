#pragma once

#include <map>
#include <optional>
#include <vector>

#include <chasles/eval/truth_examination.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/session/coverage.hpp>
#include <chasles/session/realtime.hpp>

namespace chasles {

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
  std::optional<double> scale_sigma;       ///< last one, of a filter with keep_scale [1]
};

}  // namespace chasles
