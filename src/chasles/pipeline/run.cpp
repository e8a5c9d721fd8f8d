#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/base/stopwatch.hpp>
#include <chasles/pipeline/measured_offset.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/recording/masks.hpp>

namespace chasles {
namespace {

void count(const TrackedFrame& tracked, FrontendTotals& totals) {
  const FrontendReport& r = tracked.report;
  ++totals.frames;
  totals.tracked += r.tracked;
  totals.added += r.added;
  totals.lost += r.lost();
  totals.outliers += r.lost_outlier;
  totals.stereo_tried += r.stereo_tried;
  totals.stereo_matched += r.stereo_matched;
  totals.seconds += tracked.seconds;
  totals.added_by_camera.resize(std::max(totals.added_by_camera.size(), r.cameras.size()));
  for (std::size_t c = 0; c < r.cameras.size(); ++c) {
    totals.added_by_camera[c] += r.cameras[c].added;
  }
}

// The front end's time for each frame, on the cameras' clock; estimates are on the IMU's.
class FrontendSeconds {
 public:
  void add(Time time, double seconds) { all_.emplace(time, seconds); }
  double nearest(Time time) const {
    if (all_.empty()) return 0;
    auto found = all_.lower_bound(time);
    if (found == all_.end()) return all_.rbegin()->second;
    const bool before =
        found != all_.begin() && time - std::prev(found)->first < found->first - time;
    return before ? std::prev(found)->second : found->second;
  }

 private:
  std::map<Time, double> all_;
};

// The estimate of a run whose tracks contradict the stated lens.
Estimate degrade_for_lens(Estimate e) {
  if (e.health != Health::kOk) return e;
  e.health = Health::kDegraded;
  e.degradation = Degradation::kLens;
  return e;
}

// Plays a recording through front end and estimator.
class Player {
 public:
  Player(const Recording& recording, Estimator& estimator, const FrontendSettings& frontend,
         const RunOptions& options, RunObserver& observer)
      : recording_(recording),
        estimator_(estimator),
        options_(options),
        observer_(observer),
        feed_(recording, frontend, imu_options(recording), masks_of(frontend.mask, recording),
              {.threads = options.threads,
               .realtime = options.realtime,
               .stop = [&observer] { return observer.stop(); },
               .see = [&observer](const ImageFrame& images) { observer.on_images(images); },
               .unreadable = [&observer](const InputError& e) { observer.on_unreadable(e); }}) {
    estimator.set_observer(
        [&observer](const FeatureFrame& frame, std::span<const PixelOutcome> outcomes) {
          observer.on_outcomes(frame, outcomes);
        });
  }
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;
  ~Player() { estimator_.set_observer({}); }  // the estimator may live longer than the observer

  RunReport run() {
    while (auto item = feed_.next()) {
      const bool was_frame =
          std::visit(Overloaded{[&](const FeatureFrame& frame) { return take(frame, nullptr); },
                                [&](TrackedFrame& tracked) {
                                  options_.tracks.thin(tracked.frame);
                                  return take(tracked.frame, &tracked);
                                },
                                [&](const auto& sample) { return take(sample); }},
                     *item);
      if (was_frame && (estimator_.status().ended || observer_.stop())) break;
    }
    for (const Estimate& e : estimator_.finish()) keep(e, {});
    report_.interrupted = observer_.stop();
    feed_.close();
    report_.frontend.unreadable = feed_.unreadable();
    report_.played = feed_.counts();
    if (!report_.interrupted) complete();
    report_.estimator = estimator_.report();
    return report_;
  }

 private:
  // Estimates come with the samples for which their frames wait.
  template <typename Sample>
  bool take(const Sample& sample) {
    const bool started = estimator_.started();
    const Stopwatch time;
    const std::vector<Estimate> estimates = estimator_.process(sample);
    report_.estimator_seconds += time.seconds();
    for (const Estimate& e : estimates) {
      keep(e, {.seconds = frame_time_.seconds(), .latency = latency(e, started)});
      observer_.on_progress(frames_, e.time);
    }
    return false;
  }

  bool take(const FeatureFrame& frame, const TrackedFrame* tracked) {
    if (tracked != nullptr) {
      count(*tracked, report_.frontend);
      frontend_seconds_.add(frame.time, tracked->seconds);
    }
    observer_.on_frame(frame);
    const bool started = estimator_.started();
    const Stopwatch time;
    const std::vector<Estimate> estimates = estimator_.process(frame);
    report_.estimator_seconds += time.seconds();
    if (tracked != nullptr) feed_.note_bias(estimator_.status().gyroscope_bias);
    const double each = frame_time_.seconds() / static_cast<double>(estimates.size());
    for (const Estimate& e : estimates) {
      keep(e, {.seconds = each, .latency = latency(e, started)});
    }
    observer_.on_progress(++frames_, frame.time);
    frame_time_ = {};
    return true;
  }

  std::optional<double> latency(const Estimate& estimate, bool started) const {
    return started ? feed_.seconds_since(estimate.time) : std::nullopt;
  }

  void keep(const Estimate& estimate, EstimateTiming timing) {
    any_ = true;
    const Estimate& e =
        options_.wrong_lens ? degraded_.emplace(degrade_for_lens(estimate)) : estimate;
    timing.seconds = feed_.seconds_since(e.time).value_or(timing.seconds);
    timing.frontend_seconds = frontend_seconds_.nearest(e.time);
    observer_.on_estimate(e, timing);
  }

  void complete() {
    if (!any_) {
      throw Error(
          ExitCode::kNotInitialised,
          recording_.name + ": " +
              (estimator_.started() ? "no frame gave an estimate" : estimator_.why_not_started()));
    }
    const bool smooths = estimator_.status().smooths;
    if (smooths) observer_.on_smoothing();
    const Stopwatch time;
    std::vector<Estimate> estimates = estimator_.complete([this] { return observer_.stop(); });
    if (!smooths) return;
    if (options_.wrong_lens) std::ranges::transform(estimates, estimates.begin(), degrade_for_lens);
    if (estimates.empty()) {
      report_.interrupted = report_.in_smoothing = true;
      return;
    }
    observer_.on_smoothed(estimates, time.seconds());
  }

  const Recording& recording_;
  Estimator& estimator_;
  RunOptions options_;
  RunObserver& observer_;
  SensorFeed feed_;
  RunReport report_;
  FrontendSeconds frontend_seconds_;
  std::optional<Estimate> degraded_;
  bool any_ = false;  // whether there was an estimate
  std::size_t frames_ = 0;
  Stopwatch frame_time_;
};

class Collector : public RunObserver {
 public:
  void on_estimate(const Estimate& e, const EstimateTiming&) override { all.push_back(e); }
  void on_smoothed(std::span<const Estimate> estimates, double) override {
    all.assign(estimates.begin(), estimates.end());
  }
  std::vector<Estimate> all;
};

RunResult collected(const Recording& recording, Estimator& estimator,
                    const FrontendSettings& frontend, const RunOptions& options) {
  Collector collector;
  RunReport report = run(recording, estimator, frontend, options, collector);
  return {.estimates = std::move(collector.all),
          .landmarks = estimator.map(),
          .state_names = estimator.state_names(),
          .report = std::move(report)};
}

}  // namespace

RunReport run(const Recording& recording, Estimator& estimator, const FrontendSettings& frontend,
              const RunOptions& options, RunObserver& observer) {
  return Player(recording, estimator, frontend, options, observer).run();
}

RunResult run(const Recording& recording, const InertialRunSettings& settings,
              const RunOptions& options) {
  if (options.realtime || options.as_recorded) {
    const auto estimator = make_estimator(settings, recording);
    return collected(recording, *estimator, settings.frontend, options);
  }
  const TracksEvidence evidence = examine_tracks(recording, settings);
  InertialRunSettings of_run = settings;
  start_from_measured(of_run, evidence);
  RunOptions of_all = options;
  of_all.wrong_lens = of_all.wrong_lens || evidence.has_wrong_lens();
  std::optional<Recording> mended;  // a copy only where something changes
  if (evidence.taken || of_run.filter.readout_time) {
    mended = recording;
    mend(*mended, of_run.filter, evidence);
  }
  const Recording& of_estimator = mended ? *mended : recording;
  const auto estimator = make_estimator(of_run, of_estimator);
  return collected(of_estimator, *estimator, settings.frontend, of_all);
}

RunResult run(Recording recording, const VelocityRunSettings& settings) {
  recording.images.reset();  // this kind of run takes tracks alone
  correct_clock(settings.filter, recording);
  const auto estimator = make_estimator(settings, recording);
  return collected(recording, *estimator, {}, {});
}

}  // namespace chasles
