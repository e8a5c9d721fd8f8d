#include "inertial_drive.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/data/imu_range.hpp>
#include <chasles/data/masks.hpp>
#include <chasles/error.hpp>
#include <chasles/lab/batch_trial.hpp>

#include "batch_report.hpp"
#include "calibration_report.hpp"
#include "filter_stages.hpp"
#include "frontend_seconds.hpp"
#include "image_keeper.hpp"
#include "interrupt.hpp"
#include "live_view.hpp"
#include "progress.hpp"
#include "run_input.hpp"
#include "run_landmarks.hpp"
#include "sensor_feed.hpp"
#include "sightings.hpp"
#include "stopwatch.hpp"
#include "summary.hpp"

namespace chasles::app {
namespace {

// What the front end's tracks are worth where nobody says it: measured, docs/pixels.md [px].
constexpr double kFrontendSigma = 0.5;

// The truth as it is: nothing is drawn.
InertialStart true_start(const Recording& recording) {
  if (recording.truth.empty()) {
    throw Error(
        ExitCode::kNotInitialised,
        fmt::format("{}: has no truth to begin at (--truth FILE gives one); without --begin "
                    "truth the start is found by itself",
                    recording.name));
  }
  InertialSlamSettings exact;
  exact.initial_tilt_sigma = 0;
  exact.initial_velocity_sigma = 0;
  return draw_start(recording, exact, 0, 0);
}

ImuNoise noise_of(const Recording& recording) {
  if (recording.imu_noise) return *recording.imu_noise;
  throw InputError(
      fmt::format("{}: states no IMU noise: write accelerometer_noise_density, "
                  "accelerometer_random_walk, gyroscope_noise_density and "
                  "gyroscope_random_walk into its calibration",
                  recording.name));
}

RunState run_state(const InertialEstimate& e, std::span<const Camera> cameras,
                   double milliseconds) {
  RunState state{.time = e.time,
                 .world_T_imu = e.motion.nav_T_imu,
                 .pose_covariance = e.motion.covariance.topLeftCorner<6, 6>(),
                 .extra = {e.motion.v_nav.begin(), e.motion.v_nav.end()},
                 .extra_sigma = {},
                 .nis = e.nis,
                 .nis_dof = e.nis_dof,
                 .observations = e.observations,
                 .used = e.used,
                 .rejected = e.rejected,
                 .added = e.added,
                 .in_state = e.in_state,
                 .landmarks = e.landmarks,
                 .health = name(e.health),
                 .milliseconds = milliseconds,
                 .stages = filter_stages(e.seconds)};
  state.extra.insert(state.extra.end(), e.motion.biases.begin(), e.motion.biases.end());
  for (int row = 6; row < 15; ++row) {
    state.extra_sigma.push_back(std::sqrt(e.motion.covariance(row, row)));
  }
  if (e.calibration) append_calibration(*e.calibration, cameras, state);
  return state;
}

std::vector<std::string> extra_names(const InertialSlamSettings& settings, std::size_t cameras) {
  std::vector<std::string> names;
  for (const char* of : {"velocity", "accelerometer_bias", "gyroscope_bias"}) {
    for (const char* axis : {"_x", "_y", "_z"}) names.push_back(std::string(of) + axis);
  }
  for (std::string& name : calibration_columns(settings, cameras)) names.push_back(std::move(name));
  return names;
}

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
};

ImuBuffer::Options imu_options(const Recording& recording) {
  ImuBuffer::Options options{.convention = recording.imu_convention};
  const ImuRange range = range_of(recording);
  options.accelerometer_range = std::min(options.accelerometer_range, range.accelerometer);
  options.gyroscope_range = std::min(options.gyroscope_range, range.gyroscope);
  return options;
}

InertialSession session_for(const Recording& recording, const InertialRunSettings& settings,
                            const InertialDrive& result, bool from_truth) {
  InertialSensors sensors{.cameras = recording.cameras,
                          .noise = result.imu_noise,
                          .imu = imu_options(recording),
                          .pixel_sigma = result.pixel_sigma};
  std::optional<InertialStart> start;
  if (from_truth) start = true_start(recording);
  return {settings.filter, settings.start, std::move(sensors), std::move(start)};
}

void finish(const InertialSession& session, const Sums& sums, InertialDrive& result) {
  result.run.landmarks = run_landmarks(session.map_nav());
  result.imu = session.imu_counts();
  result.resets = session.resets();
  result.dropped_frames = session.dropped_frames();
  if (sums.nees_count > 0) result.nees_state = sums.nees_state / sums.nees_count;
  if (sums.squares > 0) result.innovation_correlation = sums.products / sums.squares;
}

InertialDrive prepared(const Recording& recording, const InertialRunSettings& settings,
                       const InertialDriveOptions& options) {
  InertialDrive result;
  if (options.realtime) result.realtime = RealtimeFigures{.speed = *options.realtime};
  result.imu_noise = noise_of(recording);
  result.pixel_sigma = settings.filter.pixel_sigma.value_or(
      recording.single_pixel_sigma.value_or(recording.images ? kFrontendSigma : 1));
  result.run.name = recording.name;
  result.run.extra_names = extra_names(settings.filter, recording.cameras.size());
  result.run.stage_names = filter_stage_names();
  if (recording.images) {
    result.run.stage_names.insert(result.run.stage_names.begin(), "front_end");
  }
  result.run.truth = recording.truth;
  result.run.plan = recording.plan;
  result.run.georeference = recording.georeference;
  return result;
}

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
        session_(session_for(recording, settings, result_, options.from_truth)),
        keeper_(recording, options.keep_images),
        feed_(recording, settings.frontend, imu_options(recording),
              read_masks(settings.frontend.mask, recording.cameras),
              {.ahead = options.ahead,
               .realtime = options.realtime,
               .stop = [&interrupt] { return interrupt.requested(); },
               .see = [this](const ImageFrame& images) { keeper_.see(images); }}),
        progress_(frame_count(recording), options.quiet) {
    session_.set_witness([this](const FeatureFrame& frame, std::span<const JudgedPixel> judged) {
      keeper_.judge(frame, judged);
    });
    live_.begin(result_.run, known_json(settings, recording), frame_count(recording));
  }

  InertialDrive run() {
    while (auto item = feed_.next()) {
      if (const auto* sample = std::get_if<ImuSample>(&*item)) {
        session_.process(*sample);
        if (later_) samples_.push_back(*sample);
      } else {
        const auto* tracked = std::get_if<TrackedFrame>(&*item);
        take(tracked ? tracked->frame : std::get<FeatureFrame>(*item), tracked);
        if (interrupt_.requested()) break;
      }
    }
    for (const InertialEstimate& e : session_.finish()) keep(e, 0);
    result_.interrupted = interrupt_.requested();
    if (result_.run.states.empty() && !result_.interrupted) {
      throw Error(
          ExitCode::kNotInitialised,
          recording_.name + ": " + why_not_initialised(session_.waited(), session_.requirements()));
    }
    feed_.close();
    result_.frontend.unreadable = feed_.unreadable();
    result_.run.images = keeper_.take();
    if (result_.realtime) result_.realtime->frames = feed_.counts();
    finish(session_, sums_, result_);
    sightings_.tell(session_.in_state(), result_.run.landmarks);
    if (later_ && !result_.interrupted) replace_run();
    return std::move(result_);
  }

 private:
  void take(const FeatureFrame& frame, const TrackedFrame* tracked) {
    if (!first_) first_ = frame.time;
    if (tracked) count(*tracked, result_.frontend);
    if (tracked) frontend_seconds_.add(frame.time, tracked->seconds);
    sightings_.add(frame);
    keeper_.follow(frame);
    if (later_) seen_.push_back(frame);
    const bool running = session_.running();
    const Stopwatch filter_time;
    const std::vector<InertialEstimate> estimates = session_.process(frame);
    result_.filter_seconds += filter_time.seconds();
    if (tracked) feed_.learnt(session_.gyroscope_bias());
    for (const InertialEstimate& e : estimates) {
      keep(e, frame_time_.seconds() / static_cast<double>(estimates.size()));
      if (running) note_latency(e.time);
    }
    const double seconds = to_seconds(frame.time - *first_);
    progress_.show(++frames_, seconds);
    live_.advance(result_.run, frames_, seconds, [this] { return map_so_far(); });
    frame_time_ = {};
  }

  std::vector<RunLandmark> map_so_far() const {
    std::vector<RunLandmark> map = run_landmarks(session_.map_nav());
    sightings_.tell(session_.in_state(), map);
    return map;
  }

  // In real time, how late it is; else how long it took.
  void keep(const InertialEstimate& e, double seconds) {
    result_.still_frames += e.still ? 1 : 0;
    if (!result_.start_seconds) result_.start_seconds = to_seconds(e.time - *first_);
    sums_.add(e, settings_.filter.chart, recording_, options_.from_truth);
    result_.run.states.push_back(
        run_state(e, recording_.cameras, 1e3 * feed_.seconds_since(e.time).value_or(seconds)));
    if (recording_.images) {
      std::vector<double>& stages = result_.run.states.back().stages;
      stages.insert(stages.begin(), 1e3 * frontend_seconds_.at(e.time));
    }
    result_.calibration = e.calibration;
    if (later_) estimates_.push_back(e);
  }

  // The prior is the filter's first estimate, of which no landmark is a part yet.
  BatchInput batch_problem() const {
    const InertialEstimate& first = estimates_.front();
    InertialStart start{.time = first.time,
                        .nav_T_imu = first.motion.nav_T_imu,
                        .v_nav = first.motion.v_nav,
                        .accelerometer_bias = first.motion.biases.head<3>(),
                        .gyroscope_bias = first.motion.biases.tail<3>(),
                        .covariance = first.motion.covariance};
    BatchInput input = batch_input(recording_, settings_.filter, start);
    input.imu = imu_options(recording_);
    input.pixel_sigma = result_.pixel_sigma;
    input.samples = samples_;
    input.frames = seen_;
    for (const InertialEstimate& e : estimates_) input.initial.push_back(timed_motion(e));
    return input;
  }

  // What the other estimator finds instead of the filter's run.
  void replace_run() {
    live_.smoothing();
    const Stopwatch time;
    std::vector<InertialEstimate> found;
    if (options_.estimator.batch) {
      smooth_all(found);
    } else {
      slide_along(found);
    }
    const double milliseconds = 1e3 * time.seconds() / static_cast<double>(found.size());
    sums_ = {};
    result_.run.states.clear();
    result_.run.stage_names.clear();
    for (const InertialEstimate& e : found) {
      sums_.add(e, settings_.filter.chart, recording_, options_.from_truth);
      result_.run.states.push_back(run_state(e, recording_.cameras, milliseconds));
      result_.run.states.back().stages.clear();
    }
    result_.nees_state.reset();
    if (sums_.nees_count > 0) result_.nees_state = sums_.nees_state / sums_.nees_count;
    result_.innovation_correlation.reset();  // there are no innovations
  }

  void smooth_all(std::vector<InertialEstimate>& found) {
    const BatchResult batch = smooth(batch_problem(), settings_.filter.chart, settings_.batch);
    for (const BatchMotion& motion : batch.motions) {
      InertialEstimate& e = found.emplace_back(estimate_of(motion));
      e.landmarks = batch.report.landmarks;
      e.health = believable(batch.report) ? Health::kOk : Health::kDegraded;
    }
    result_.run.landmarks = run_landmarks(batch.landmarks);
    sightings_.tell(std::nullopt, result_.run.landmarks);
    result_.batch = batch.report;
  }

  void slide_along(std::vector<InertialEstimate>& found) {
    const InertialWindowResult window =
        slide(batch_problem(), settings_.filter.chart, settings_.batch, options_.estimator.window);
    for (const WindowMotion& motion : window.motions) found.push_back(estimate_of(motion));
    result_.run.landmarks = run_landmarks(window.landmarks);
    sightings_.tell(window.in_window, result_.run.landmarks);
    result_.window = window.report;
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
  InertialSession session_;
  ImageKeeper keeper_;
  SensorFeed feed_;
  Progress progress_;
  Sums sums_;
  FrontendSeconds frontend_seconds_;
  Sightings sightings_;
  std::optional<Time> first_;  // frame
  // For batch estimation and windows.
  const bool later_ = !options_.estimator.filter();
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
