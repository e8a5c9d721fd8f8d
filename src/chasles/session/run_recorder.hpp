#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <chasles/live/live_run.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/session/observation_spans.hpp>
#include <chasles/session/recorded_run.hpp>

namespace chasles {

/// Records what a run gives, as one of its observers: states, landmarks with the times of their
/// observations, and figures.
class RunRecorder : public RunObserver {
 public:
  struct Options {
    /// Columns of states.csv after those of the estimator (calibration_report.hpp).
    std::vector<std::string> calibration_columns = {};
    bool has_stages = false;              ///< for timing.csv; a window has none
    int frames_per_estimate = 1;          ///< above 1 for a window with fewer keyframes than frames
    std::optional<double> realtime = {};  ///< as RunOptions::realtime
    bool truth_is_comparable = true;      ///< during the run: it has attitudes and the right clock
    /// For a run that started at the truth: the chart of nees_state.
    std::optional<std::string> truth_chart = {};
    Trajectory dead_reckoning = {};           ///< for viewers and the page
    std::optional<MapSketch> prior_map = {};  ///< in which the estimator looks for its place
  };

  /// Recording and estimator must outlive it.
  RunRecorder(const Recording& recording, const Estimator& estimator, Options options);

  /// Before the first frame: the run that viewers begin with. It has the truth only if that is
  /// comparable.
  Run header() const;
  /// The run so far, without landmarks.
  const Run& run() const { return result_.run; }
  /// What the run has found so far. Takes time.
  LiveMap live_map() const;
  /// From the first frame, of which there is one, to a time [s].
  double recorded_seconds(Time now) const { return to_seconds(now - *first_frame_); }

  void on_frame(const FeatureFrame& frame) override;
  void on_estimate(const Estimate& e, const EstimateTiming& timing) override;
  void on_smoothed(std::span<const Estimate> estimates, double seconds) override;

  /// The results, with the landmarks and smoothed poses of the estimator. Once, after the run,
  /// whose report this is.
  RecordedRun finish(RunReport report);

 private:
  /// Sums over the states.
  struct Sums {
    double nees_state = 0, products = 0, squares = 0;
    int nees_count = 0;
    std::map<Degradation, int> degradations;
  };

  void note_start(Time first_estimate);
  void note_place(Time time, const PoseInMap& place);
  RunState& add_state(const Estimate& e, double seconds);
  void add_to_sums(const Estimate& e);
  void report_sums();
  std::vector<RunLandmark> landmarks(const EstimatedMap& whole) const;

  const Recording& recording_;
  const Estimator& estimator_;
  Options options_;
  RecordedRun result_;
  Sums sums_;
  ObservationSpans spans_;
  std::optional<Time> first_frame_;
  Time latest_frame_{};
  std::size_t frames_ = 0, estimated_ = 0;
};

}  // namespace chasles
