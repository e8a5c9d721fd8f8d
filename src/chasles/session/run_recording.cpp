#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <spdlog/spdlog.h>

#include <chasles/codec/utf8.hpp>
#include <chasles/pipeline/truth.hpp>
#include <chasles/session/image_keeper.hpp>
#include <chasles/session/observation_spans.hpp>
#include <chasles/session/progress.hpp>
#include <chasles/session/recognition_report.hpp>
#include <chasles/session/run_landmarks.hpp>
#include <chasles/session/run_recording.hpp>
#include <chasles/session/run_state.hpp>
#include <chasles/velocity/velocity_slam.hpp>

namespace chasles {
namespace {

std::vector<double> stages(const StageSeconds& s) {
  return {1e3 * s.propagation, 1e3 * s.update, 1e3 * s.landmarks};
}

// Figures accumulated over the frames.
struct Sums {
  double nees_state = 0, products = 0, squares = 0;
  int nees_count = 0;
  std::map<Degradation, int> degradations;

  // Only a run that starts at the truth has the world of the truth.
  void add(const Estimate& e, const Recording& recording,
           const std::optional<std::string>& truth_chart) {
    const double nees =
        truth_chart && e.v_world ? state_nees(*truth_chart, recording, e) : std::nan("");
    if (std::isfinite(nees)) {
      nees_state += nees;
      ++nees_count;
    }
    if (e.health == Health::kDegraded && e.degradation != Degradation::kNone)
      ++degradations[e.degradation];
    products += e.innovation_products;
    squares += e.innovation_squares;
  }

  void report(RecordedRun& result) const {
    result.degradations = degradations;
    if (nees_count > 0) result.nees_state = nees_state / nees_count;
    if (squares > 0) result.innovation_correlation = products / squares;
  }
};

// Records the results of a run, and updates progress bar and observer.
class Recorder : public RunObserver {
 public:
  Recorder(const Recording& recording, Estimator& estimator, const RunRecordingOptions& options,
           const StopRequest& stop, SessionObserver& observer)
      : recording_(recording),
        estimator_(estimator),
        options_(options),
        stop_(stop),
        observer_(observer),
        keeper_(recording, options.keep_images),
        progress_(frame_count(recording), options.quiet) {
    Run& run = result_.run;
    run.name = recording.name;
    run.extra_names = estimator.state_names();
    run.extra_names.insert(run.extra_names.end(), options.calibration_columns.begin(),
                           options.calibration_columns.end());
    if (!options.estimator.is_window()) {
      if (recording.images) run.stage_names = {"front_end"};
      for (const char* stage : {"propagation", "update", "landmarks"}) {
        run.stage_names.emplace_back(stage);
      }
    }
    if (options.truth_is_comparable) run.truth = recording.truth;
    run.pairing = recording.pairing;
    run.plan = recording.plan;
    run.georeference = recording.georeference;
    run.dead_reckoning = options.dead_reckoning;
    result_.has_prior_map = options.prior_map.has_value();
    if (options.run.realtime) result_.realtime = RealtimeFigures{.speed = *options.run.realtime};
    observer.begin(run, options.known, recording);
    run.truth = recording.truth;
  }

  RecordedRun finish(RunReport report) {
    if (result_.realtime) result_.realtime->frames = report.played;
    FrameCoverage& coverage = result_.coverage;
    coverage.frames = report.interrupted ? frames_ : frame_count(recording_);
    coverage.estimated = std::min(
        coverage.frames, estimated_ * static_cast<std::size_t>(options_.frames_per_estimate));
    result_.report = std::move(report);
    const EstimatedMap whole = estimator_.whole_map();
    result_.run.landmarks = map(whole);
    for (const PastPose& pose : whole.poses) {
      result_.run.smoothed.push_back(
          {.time = pose.time, .world_T_imu = pose.map_T_imu, .pose_covariance = pose.covariance});
    }
    result_.run.images = keeper_.take();
    sums_.report(result_);
    return std::move(result_);
  }

  bool stop() override { return stop_(); }
  void on_images(const ImageFrame& images) override {
    keeper_.see(images);
    observer_.on_images(images);
  }
  // A camera may have no image that can be read, of thousands.
  void on_unreadable(const InputError& error) override {
    constexpr int kMostWarnings = 20;
    if (++unreadable_ > kMostWarnings) return;
    spdlog::warn("{}", error.what());
    if (unreadable_ == kMostWarnings) spdlog::warn("further unreadable images are only counted");
  }
  void on_frame(const FeatureFrame& frame) override {
    if (!first_) first_ = frame.time;
    latest_ = frame.time;
    ++frames_;
    spans_.add(frame);
    keeper_.follow(frame);
    observer_.on_frame(frame);
  }
  void on_outcomes(const FeatureFrame& frame, std::span<const PixelOutcome> outcomes) override {
    keeper_.note_outcomes(frame, outcomes);
    observer_.on_outcomes(frame, outcomes);
  }

  void on_estimate(const Estimate& e, const EstimateTiming& timing) override {
    if (!result_.start_seconds) {
      result_.start_seconds = to_seconds(e.time - *first_);
      result_.initialised_seconds = to_seconds(latest_ - *first_);
      result_.coverage.before_start = frames_ - 1;
    }
    if (e.in_map) {
      result_.run.in_map.push_back({.time = e.time,
                                    .world_T_imu = e.in_map->map_T_imu,
                                    .pose_covariance = e.in_map->covariance});
      std::optional<MapSketch>& map = result_.run.prior_map;
      if (!map) map = options_.prior_map.value_or(MapSketch{});
      map->world_T_map = e.in_map->world_T_map;
    }
    estimated_ += e.health == Health::kLost ? 0 : 1;
    result_.zupt_frames += e.zero_velocity ? 1 : 0;
    result_.calibration = e.calibration;
    if (result_.realtime && timing.latency) result_.realtime->latency.push_back(*timing.latency);
    RunState& state = add(e, timing.seconds);
    if (!e.seconds) return;
    state.stages = stages(*e.seconds);
    if (recording_.images) {
      state.stages.insert(state.stages.begin(), 1e3 * timing.frontend_seconds);
    }
  }

  void on_progress(std::size_t frames, Time now) override {
    const double seconds = to_seconds(now - *first_);
    progress_.show(frames, seconds);
    observer_.advance(result_.run, frames, seconds, [this] { return live_map(); });
  }

  void on_smoothing() override { observer_.smoothing(); }
  void on_smoothed(std::span<const Estimate> estimates, double seconds) override {
    result_.run.states.clear();
    result_.run.stage_names.clear();
    sums_ = {};
    for (const Estimate& e : estimates) add(e, seconds / static_cast<double>(estimates.size()));
  }

 private:
  RunState& add(const Estimate& e, double seconds) {
    sums_.add(e, recording_, options_.truth_chart);
    result_.run.states.push_back(run_state(e, recording_.cameras));
    result_.run.states.back().milliseconds = 1e3 * seconds;
    return result_.run.states.back();
  }

  std::vector<RunLandmark> map(const EstimatedMap& whole) const {
    std::vector<RunLandmark> map = run_landmarks(whole.landmarks, whole.initial);
    spans_.fill_in(whole.in_state, map);
    return map;
  }

  LiveMap live_map() const {
    const nlohmann::ordered_json known =
        recognition_json(estimator_.report(), result_.run, result_.has_prior_map);
    return {.landmarks = map(estimator_.whole_map()),
            .known = json_text(known),
            .prior_map = result_.run.prior_map};
  }

  const Recording& recording_;
  Estimator& estimator_;
  const RunRecordingOptions& options_;
  const StopRequest& stop_;
  SessionObserver& observer_;
  RecordedRun result_;
  ImageKeeper keeper_;
  Progress progress_;
  Sums sums_;
  ObservationSpans spans_;
  std::optional<Time> first_;  // first frame
  Time latest_{};              // latest frame
  std::size_t frames_ = 0, estimated_ = 0;
  int unreadable_ = 0;  // frames with an image that cannot be read
};

}  // namespace

RecordedRun run_recording(const Recording& recording, Estimator& estimator,
                          const RunRecordingOptions& options, const StopRequest& stop,
                          SessionObserver& observer) {
  Recorder recorder(recording, estimator, options, stop, observer);
  return recorder.finish(run(recording, estimator, options.frontend, options.run, recorder));
}

Trajectory dead_reckoning(const Recording& recording) {
  VelocitySlamSettings settings;
  settings.mode = SlamMode::kLocalize;
  settings.velocity = VelocityRole::kInput;
  settings.hold = VelocityHold::kMidpoint;
  VelocitySlam slam(settings, recording.rig, VelocitySlamNoise{});
  Trajectory trajectory;
  EventStream events(recording);
  bool lost = false;
  while (const auto event = lost ? std::nullopt : events.next()) {
    std::visit(Overloaded{[&](const BodyVelocity& velocity) { slam.process(velocity); },
                          [&](const FeatureFrame& frame) {
                            const Estimate e = slam.process(frame);
                            lost = e.health == Health::kLost;
                            if (!lost)
                              trajectory.push_back({.time = e.time, .pose = e.world_T_imu});
                          },
                          [](const auto& /*other*/) {}},
               *event);
  }
  return trajectory;
}

}  // namespace chasles
