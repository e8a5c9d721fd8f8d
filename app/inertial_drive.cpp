#include "inertial_drive.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <nlohmann/json.hpp>

#include <chasles/data/masks.hpp>
#include <chasles/error.hpp>
#include <chasles/lab/batch_trial.hpp>

#include "batch_report.hpp"
#include "frontend_seconds.hpp"
#include "image_keeper.hpp"
#include "inertial_estimating.hpp"
#include "interrupt.hpp"
#include "live_view.hpp"
#include "observation_spans.hpp"
#include "progress.hpp"
#include "run_input.hpp"
#include "run_landmarks.hpp"
#include "sensor_feed.hpp"
#include "stopwatch.hpp"
#include "summary.hpp"

namespace chasles::app {
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
}

// The figures that are sums over the frames.
struct Sums {
  double nees_state = 0, products = 0, squares = 0;
  int nees_count = 0;

  // A nav of the run's own is not the truth's: only from the true start on are they the same.
  void add(const InertialEstimate& e, const std::string& chart, const Recording& recording,
           bool from_truth) {
    const double nees = from_truth ? state_nees(chart, recording, e.time, e.motion) : std::nan("");
    if (std::isfinite(nees)) {
      nees_state += nees;
      ++nees_count;
    }
    products += e.innovation_products;
    squares += e.innovation_squares;
  }

  // Without innovations nothing is said of them.
  void tell(InertialDrive& result) const {
    result.nees_state.reset();
    result.innovation_correlation.reset();
    if (nees_count > 0) result.nees_state = nees_state / nees_count;
    if (squares > 0) result.innovation_correlation = products / squares;
  }
};

// A recording on its way through front end and filter.
class Loop {
 public:
  Loop(const Recording& recording, const InertialRunSettings& settings,
       const InertialDriveOptions& options, const Interrupt& interrupt, LiveView& live)
      : recording_(recording),
        settings_(settings),
        options_(options),
        interrupt_(interrupt),
        live_(live),
        result_(prepared(recording, settings, options)),
        estimating_(recording, settings, options, result_),
        keeper_(recording, options.keep_images),
        feed_(recording, settings.frontend, imu_options(recording),
              read_masks(settings.frontend.mask, recording.cameras),
              {.threads = options.threads,
               .realtime = options.realtime,
               .stop = [&interrupt] { return interrupt.requested(); },
               .see = [this](const ImageFrame& images) { keeper_.see(images); }}),
        progress_(frame_count(recording), options.quiet) {
    estimating_.session().set_observer(
        [this](const FeatureFrame& frame, std::span<const PixelOutcome> judged) {
          keeper_.judge(frame, judged);
        });
    live_.begin(result_.run, known_json(settings, recording), frame_count(recording));
  }

  InertialDrive run() {
    while (auto item = feed_.next()) {
      if (const auto* sample = std::get_if<ImuSample>(&*item)) {
        take(*sample);
      } else {
        auto* tracked = std::get_if<TrackedFrame>(&*item);
        if (tracked) options_.tracks.thin(tracked->frame);
        take(tracked ? tracked->frame : std::get<FeatureFrame>(*item), tracked);
        if (interrupt_.requested()) break;
      }
    }
    for (const InertialEstimate& e : estimating_.finish()) keep(e, 0);
    result_.interrupted = interrupt_.requested();
    if (result_.run.states.empty() && !result_.interrupted) {
      const InertialSession& session = estimating_.session();
      throw Error(
          ExitCode::kNotInitialised,
          recording_.name + ": " + why_not_initialised(session.waited(), session.requirements()));
    }
    feed_.close();
    result_.frontend.unreadable = feed_.unreadable();
    result_.run.images = keeper_.take();
    if (result_.realtime) result_.realtime->frames = feed_.counts();
    estimating_.report(result_);
    sums_.tell(result_);
    observation_spans_.tell(estimating_.in_state(), result_.run.landmarks);
    if (options_.estimator.batch && !result_.interrupted) smooth_all();
    return std::move(result_);
  }

 private:
  // A window's estimates come with the samples that its frames wait for.
  void take(const ImuSample& sample) {
    if (options_.estimator.batch) samples_.push_back(sample);
    const Stopwatch time;
    for (const InertialEstimate& e : estimating_.process(sample)) {
      keep(e, frame_time_.seconds());
      show(e.time);
    }
    if (options_.estimator.window > 0) result_.filter_seconds += time.seconds();
  }

  void take(const FeatureFrame& frame, const TrackedFrame* tracked) {
    if (!first_) first_ = frame.time;
    if (tracked) count(*tracked, result_.frontend);
    if (tracked) frontend_seconds_.add(frame.time, tracked->seconds);
    observation_spans_.add(frame);
    keeper_.follow(frame);
    if (options_.estimator.batch) seen_.push_back(frame);
    const bool running = estimating_.running();
    const Stopwatch filter_time;
    const std::vector<InertialEstimate> estimates = estimating_.process(frame);
    result_.filter_seconds += filter_time.seconds();
    if (tracked) feed_.learnt(estimating_.gyroscope_bias());
    for (const InertialEstimate& e : estimates) {
      keep(e, frame_time_.seconds() / static_cast<double>(estimates.size()));
      if (running) note_latency(e.time);
    }
    ++frames_;
    show(frame.time);
    frame_time_ = {};
  }

  void show(Time now) {
    const double seconds = to_seconds(now - *first_);
    progress_.show(frames_, seconds);
    live_.advance(result_.run, frames_, seconds, [this] { return map_so_far(); });
  }

  std::vector<RunLandmark> map_so_far() const {
    std::vector<RunLandmark> map = run_landmarks(estimating_.map());
    observation_spans_.tell(estimating_.in_state(), map);
    return map;
  }

  // In real time, how late it is; else how long it took.
  void keep(const InertialEstimate& e, double seconds) {
    result_.zupt_frames += e.still ? 1 : 0;
    if (!result_.start_seconds) result_.start_seconds = to_seconds(e.time - *first_);
    sums_.add(e, settings_.filter.chart, recording_, options_.from_truth);
    result_.run.states.push_back(
        run_state(e, recording_.cameras, 1e3 * feed_.seconds_since(e.time).value_or(seconds)));
    std::vector<double>& stages = result_.run.states.back().stages;
    if (options_.estimator.window > 0) {
      stages.clear();
    } else if (recording_.images) {
      stages.insert(stages.begin(), 1e3 * frontend_seconds_.at(e.time));
    }
    result_.calibration = e.calibration;
    if (options_.estimator.batch) estimates_.push_back(e);
  }

  // What batch estimation finds instead of the filter's run.
  void smooth_all() {
    live_.smoothing();
    const Stopwatch time;
    InertialBatchInput input = smoothing_input(recording_, settings_, result_, estimates_.front());
    input.samples = std::move(samples_);
    input.frames = std::move(seen_);
    for (const InertialEstimate& e : estimates_) input.initial.push_back(timed_motion(e));
    const InertialBatchResult batch = smooth(input, settings_.filter.chart, settings_.batch);
    const double milliseconds = 1e3 * time.seconds() / static_cast<double>(batch.motions.size());
    sums_ = {};
    result_.run.states.clear();
    result_.run.stage_names.clear();
    for (const BatchMotion& motion : batch.motions) {
      InertialEstimate e = estimate_of(motion);
      e.landmarks = batch.report.landmarks;
      e.health = believable(batch.report) ? Health::kOk : Health::kDegraded;
      sums_.add(e, settings_.filter.chart, recording_, options_.from_truth);
      result_.run.states.push_back(run_state(e, recording_.cameras, milliseconds));
      result_.run.states.back().stages.clear();
    }
    sums_.tell(result_);
    result_.run.landmarks = run_landmarks(batch.landmarks);
    observation_spans_.tell(std::nullopt, result_.run.landmarks);
    result_.batch = batch.report;
  }

  void note_latency(Time time) {
    if (result_.realtime) result_.realtime->latency.push_back(*feed_.seconds_since(time));
  }

  const Recording& recording_;
  const InertialRunSettings& settings_;
  const InertialDriveOptions& options_;
  const Interrupt& interrupt_;
  LiveView& live_;
  InertialDrive result_;
  InertialEstimating estimating_;
  ImageKeeper keeper_;
  SensorFeed feed_;
  Progress progress_;
  Sums sums_;
  FrontendSeconds frontend_seconds_;
  ObservationSpans observation_spans_;
  std::optional<Time> first_;  // frame
  // For batch estimation.
  std::vector<ImuSample> samples_;
  std::vector<FeatureFrame> seen_;
  std::vector<InertialEstimate> estimates_;
  std::size_t frames_ = 0;
  Stopwatch frame_time_;
};

}  // namespace

InertialDrive drive(const Recording& recording, const InertialRunSettings& settings,
                    const InertialDriveOptions& options, const Interrupt& interrupt,
                    LiveView& live) {
  if (recording.cameras.empty()) throw InputError(recording.name + ": has no camera");
  return Loop(recording, settings, options, interrupt, live).run();
}

}  // namespace chasles::app
