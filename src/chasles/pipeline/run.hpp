#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <chasles/data/recording.hpp>
#include <chasles/pipeline/estimator.hpp>
#include <chasles/pipeline/sensor_feed.hpp>
#include <chasles/pipeline/tracks_part.hpp>

// A recording through front end and estimator: `chasles run` as a function.
namespace chasles {

/// What the front end did, summed over the frames.
struct FrontendTotals {
  int frames = 0;
  int unreadable = 0;  ///< images, taken for missing
  long tracked = 0, added = 0, lost = 0, outliers = 0, stereo_tried = 0, stereo_matched = 0;
  double seconds = 0;  ///< that it took, without reading the images
};

struct RunOptions {
  int threads = 3;                 ///< as SensorFeedOptions::threads
  std::optional<double> realtime;  ///< as SensorFeedOptions::realtime
  TracksPart tracks;               ///< of those that the front end follows
};

/// When an estimate came.
struct EstimateTiming {
  double seconds = 0;             ///< that its frame took, or in real time how late it came
  double frontend_seconds = 0;    ///< that the front end took for the frame nearest to its time
  std::optional<double> latency;  ///< in real time, of a run that had started before [s]
};

/// What happens in a run, for progress bars, live views and files. Each function does nothing
/// unless it is overridden; none may change the recording or the estimator.
class RunObserver {
 public:
  virtual ~RunObserver() = default;

  virtual bool stop() { return false; }             ///< asked after every frame, from any thread
  virtual void on_images(const ImageFrame&) {}      ///< perhaps from another thread
  virtual void on_unreadable(const InputError&) {}  ///< the same
  virtual void on_frame(const FeatureFrame&) {}     ///< before it is processed
  virtual void on_outcomes(const FeatureFrame&, std::span<const PixelOutcome>) {}
  virtual void on_estimate(const Estimate&, const EstimateTiming&) {}
  /// So many frames are done, the last one at that time.
  virtual void on_progress(std::size_t /*frames*/, Time /*now*/) {}
  virtual void on_smoothing() {}  ///< batch estimation begins
  /// Batch estimation has ended: all estimates so far are replaced by these.
  virtual void on_smoothed(std::span<const Estimate>, double /*seconds*/) {}
};

/// How a run went.
struct RunReport {
  EstimatorReport estimator;
  FrontendTotals frontend;
  double estimator_seconds = 0;  ///< without batch estimation
  bool interrupted = false;      ///< by RunObserver::stop()
  Playback::Counts played;       ///< in real time: images or frames
};

/// Runs the estimator over the recording. Throws Error(kNotInitialised) with what was missing where
/// the run never started; what the estimator throws.
RunReport run(const Recording& recording, Estimator& estimator, const FrontendSettings& frontend,
              const RunOptions& options, RunObserver& observer);

/// All of a run in memory.
struct RunResult {
  std::vector<Estimate> estimates;
  std::vector<MapLandmark> landmarks;
  std::vector<std::string> state_names;  ///< of Estimate::v_world, if any, and additive
  RunReport report;
};

/// The same with an estimator of its own, of the kind that the settings choose. With the defaults
/// the estimates are those of `chasles run`, to the bit.
RunResult run(const Recording& recording, const InertialRunSettings& settings,
              const RunOptions& options = {});
/// Of a recording with body velocities. Corrects their clock first, as correct_clock().
RunResult run(Recording recording, const VelocityRunSettings& settings);

}  // namespace chasles
