#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <chasles/pipeline/estimator.hpp>
#include <chasles/pipeline/sensor_feed.hpp>
#include <chasles/pipeline/tracks_part.hpp>
#include <chasles/recording/recording.hpp>

// Runs a recording through front end and estimator: `chasles run` as a function.
namespace chasles {

/// Totals of the front end over the frames.
struct FrontendTotals {
  int frames = 0;
  int unreadable = 0;  ///< frames with an image that cannot be read, which counts as missing
  long tracked = 0, added = 0, lost = 0, outliers = 0, stereo_tried = 0, stereo_matched = 0;
  std::vector<long> added_by_camera = {};  ///< of `added`, those that each camera found
  double seconds = 0;                      ///< its time, without reading the images
};

struct RunOptions {
  int threads = 3;                      ///< as SensorFeedOptions::threads
  std::optional<double> realtime = {};  ///< as SensorFeedOptions::realtime
  TracksPart tracks = {};               ///< those that the front end follows
  bool as_recorded = false;             ///< without examine_tracks()
  /// The tracks contradict the stated lens (TracksEvidence): estimates that would be `ok` are
  /// degraded, with Degradation::kLens.
  bool wrong_lens = false;
};

/// Timing of an estimate.
struct EstimateTiming {
  double seconds = 0;                  ///< processing time of its frame, or in real time the delay
  double frontend_seconds = 0;         ///< time of the front end for the frame nearest to its time
  std::optional<double> latency = {};  ///< in real time, for a run that had started before [s]
};

/// Who follows a run: what records it, keeps images, draws a progress bar or shows it to viewers.
/// Each function does nothing unless it is overridden; none may change the recording or the
/// estimator. Several observers are an ObserverList.
class RunObserver {
 public:
  virtual ~RunObserver() = default;

  /// Polled after every frame and during batch estimation, from any thread.
  virtual bool stop() { return false; }
  /// As SensorFeedOptions::see: may run on another thread than the functions below.
  virtual void on_images(const ImageFrame&) {}
  virtual void on_unreadable(const InputError&) {}  ///< as SensorFeedOptions::unreadable
  virtual void on_frame(const FeatureFrame&) {}     ///< before it is processed
  virtual void on_outcomes(const FeatureFrame&, std::span<const PixelOutcome>) {}
  virtual void on_estimate(const Estimate&, const EstimateTiming&) {}
  /// Number of processed frames, and the time of the last one.
  virtual void on_progress(std::size_t /*frames*/, Time /*now*/) {}
  virtual void on_smoothing() {}  ///< batch estimation begins
  /// Batch estimation has ended: these replace all estimates so far.
  virtual void on_smoothed(std::span<const Estimate>, double /*seconds*/) {}
};

/// The report of a run.
struct RunReport {
  EstimatorReport estimator;
  FrontendTotals frontend;
  double estimator_seconds = 0;  ///< without batch estimation
  bool interrupted = false;      ///< by RunObserver::stop()
  bool in_smoothing = false;     ///< that was in batch estimation: the estimates are the filter's
  Playback::Counts played;       ///< in real time: images or frames
};

/// Runs the estimator over the recording. Throws Error(kNotInitialised) with the unmet conditions
/// where the run never started, and the exceptions of the estimator.
RunReport run(const Recording& recording, Estimator& estimator, const FrontendSettings& frontend,
              const RunOptions& options, RunObserver& observer);

/// All results of a run.
struct RunResult {
  std::vector<Estimate> estimates;
  std::vector<MapLandmark> landmarks;
  std::vector<std::string> state_names;  ///< components of Estimate::v_world, if any, and additive
  RunReport report;
};

/// The same with an estimator of the kind that the settings choose, and what examine_tracks() finds
/// unless it plays in real time. With the defaults the estimates are those of `chasles run`, to the
/// bit.
RunResult run(const Recording& recording, const InertialRunSettings& settings,
              const RunOptions& options = {});
/// For a recording with body velocities. Corrects their clock first, as correct_clock().
RunResult run(Recording recording, const VelocityRunSettings& settings);

}  // namespace chasles
