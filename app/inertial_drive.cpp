#include "inertial_drive.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include <chasles/error.hpp>
#include <chasles/lab/trial.hpp>
#include <chasles/slam/feature_feed.hpp>

#include "interrupt.hpp"
#include "progress.hpp"
#include "run_input.hpp"
#include "stopwatch.hpp"
#include "summary.hpp"

namespace chasles::app {
namespace {

using Json = nlohmann::ordered_json;

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

RunState run_state(const InertialEstimate& e, double milliseconds) {
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
                 .milliseconds = milliseconds};
  state.extra.insert(state.extra.end(), e.motion.biases.begin(), e.motion.biases.end());
  for (int row = 6; row < 15; ++row) {
    state.extra_sigma.push_back(std::sqrt(e.motion.covariance(row, row)));
  }
  return state;
}

std::vector<std::string> extra_names() {
  std::vector<std::string> names;
  for (const char* of : {"velocity", "accelerometer_bias", "gyroscope_bias"}) {
    for (const char* axis : {"_x", "_y", "_z"}) names.push_back(std::string(of) + axis);
  }
  return names;
}

// The events of a recording, its images read when their time has come. One that cannot be read
// counts as missing.
class Events {
 public:
  explicit Events(const Recording& recording) : recording_(&recording), stream_(recording) {}

  std::optional<SensorEvent> next() {
    while (auto event = stream_.next()) {
      if (auto* sample = std::get_if<ImuSample>(&*event)) return *sample;
      if (auto* frame = std::get_if<FeatureFrame>(&*event)) return std::move(*frame);
      if (const auto* due = std::get_if<ImagesDue>(&*event)) return read(*due);
    }
    return std::nullopt;
  }
  int unreadable() const { return unreadable_; }

 private:
  ImageFrame read(const ImagesDue& due) {
    try {
      return recording_->images->read(due.index);
    } catch (const InputError& error) {
      ++unreadable_;
      spdlog::warn("{}", error.what());
      return {.time = due.time, .images = std::vector<GrayImage>(recording_->cameras.size())};
    }
  }

  const Recording* recording_;
  EventStream stream_;
  int unreadable_ = 0;
};

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

Json frontend_json(const FrontendTotals& t) {
  return {{"frames", t.frames},
          {"unreadable", t.unreadable},
          {"tracked", t.tracked},
          {"added", t.added},
          {"lost", t.lost},
          {"outliers", t.outliers},
          {"stereo_tried", t.stereo_tried},
          {"stereo_matched", t.stereo_matched}};
}

InertialSession session_for(const Recording& recording, const InertialRunSettings& settings,
                            const InertialDrive& result, bool from_truth) {
  InertialSensors sensors{.cameras = recording.cameras,
                          .noise = result.imu_noise,
                          .imu = {.convention = recording.imu_convention},
                          .pixel_sigma = result.pixel_sigma};
  std::optional<InertialStart> start;
  if (from_truth) start = true_start(recording);
  return {settings.filter, settings.start, std::move(sensors), std::move(start)};
}

void finish(const InertialSession& session, const Sums& sums, InertialDrive& result) {
  for (const MapLandmark& l : session.map_nav()) {
    result.run.landmarks.push_back({.id = l.id,
                                    .p_world = l.p_world,
                                    .covariance = l.covariance,
                                    .observations = l.observations});
  }
  result.imu = session.imu_counts();
  result.resets = session.resets();
  result.dropped_frames = session.dropped_frames();
  if (sums.nees_count > 0) result.nees_state = sums.nees_state / sums.nees_count;
  if (sums.squares > 0) result.innovation_correlation = sums.products / sums.squares;
}

}  // namespace

InertialDrive drive(const Recording& recording, const InertialRunSettings& settings,
                    const InertialDriveOptions& options, const Interrupt& interrupt) {
  if (recording.cameras.empty()) throw InputError(recording.name + ": has no camera");
  InertialDrive result;
  result.imu_noise = noise_of(recording);
  result.pixel_sigma =
      settings.filter.pixel_sigma.value_or(recording.single_pixel_sigma.value_or(1));
  result.run.name = recording.name;
  result.run.extra_names = extra_names();
  result.run.truth = recording.truth;
  InertialSession session = session_for(recording, settings, result, options.from_truth);
  Events events(recording);
  std::optional<FeatureFeed> feed(
      std::in_place, [&] { return events.next(); }, settings.frontend, recording.cameras,
      ImuBuffer::Options{.convention = recording.imu_convention},
      options.ahead && recording.images != nullptr);
  Progress progress(frame_count(recording), options.quiet);
  Sums sums;
  std::optional<Time> first;
  std::size_t frames = 0;
  Stopwatch frame_time;
  while (auto item = feed->next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*item)) {
      session.process(*sample);
      continue;
    }
    const auto* tracked = std::get_if<TrackedFrame>(&*item);
    const FeatureFrame& frame = tracked ? tracked->frame : std::get<FeatureFrame>(*item);
    if (!first) first = frame.time;
    if (tracked) count(*tracked, result.frontend);
    const Stopwatch filter_time;
    const std::vector<InertialEstimate> estimates = session.process(frame);
    result.filter_seconds += filter_time.seconds();
    if (tracked) feed->learnt(session.gyroscope_bias());
    for (const InertialEstimate& e : estimates) {
      if (!result.start_seconds) result.start_seconds = to_seconds(e.time - *first);
      sums.add(e, settings.filter.chart, recording, options.from_truth);
      result.run.states.push_back(
          run_state(e, 1e3 * frame_time.seconds() / static_cast<double>(estimates.size())));
    }
    progress.show(++frames, to_seconds(frame.time - *first));
    result.interrupted = interrupt.requested();
    if (result.interrupted) break;
    frame_time = {};
  }
  if (result.run.states.empty() && !result.interrupted) {
    throw Error(
        ExitCode::kNotInitialised,
        recording.name + ": " + why_not_initialised(session.waited(), session.requirements()));
  }
  feed.reset();  // its thread is done with `events`
  result.frontend.unreadable = events.unreadable();
  finish(session, sums, result);
  return result;
}

Json timing_json(const InertialDrive& drive, const Json& timing) {
  Json all = timing;
  const auto frames = static_cast<double>(drive.run.states.size());
  if (drive.frontend.frames > 0) {
    all["frontend_ms_per_frame"] = 1e3 * drive.frontend.seconds / drive.frontend.frames;
  }
  all["filter_ms_per_frame"] = frames > 0 ? Json(1e3 * drive.filter_seconds / frames) : Json();
  return all;
}

Json summary_json(const InertialDrive& drive, const InertialRunSettings& settings,
                  const Recording& recording) {
  std::vector<std::string> remarks = recording.remarks;
  if (drive.frontend.unreadable > 0) {
    remarks.push_back(fmt::format("{} frames with an image that cannot be read: taken as missing",
                                  drive.frontend.unreadable));
  }
  if (drive.dropped_frames > 0) {
    remarks.push_back(fmt::format("{} frames late, there twice, or without IMU samples: dropped",
                                  drive.dropped_frames));
  }
  if (drive.resets > 0) {
    remarks.push_back(fmt::format("the filter was lost and began anew {} times", drive.resets));
  }
  Json summary =
      run_json(drive.run, "slam", settings.filter.chart, recording.true_landmarks, remarks);
  summary["nees_state"] = drive.nees_state ? Json(*drive.nees_state) : Json();
  summary["innovation_correlation"] =
      drive.innovation_correlation ? Json(*drive.innovation_correlation) : Json();
  summary["start_seconds"] = drive.start_seconds ? Json(*drive.start_seconds) : Json();
  summary["resets"] = drive.resets;
  summary["dropped_frames"] = drive.dropped_frames;
  if (recording.images) summary["frontend"] = frontend_json(drive.frontend);
  summary["settings"] = settings_json(settings);
  const ImuNoise& noise = drive.imu_noise;
  summary["noise"] = {{"pixel_sigma", drive.pixel_sigma},
                      {"accelerometer_noise_density", noise.accelerometer_noise_density},
                      {"accelerometer_random_walk", noise.accelerometer_random_walk},
                      {"gyroscope_noise_density", noise.gyroscope_noise_density},
                      {"gyroscope_random_walk", noise.gyroscope_random_walk}};
  const ImuBuffer::Counts& imu = drive.imu;
  summary["imu"] = {{"used", imu.used},           {"not_finite", imu.not_finite},
                    {"not_later", imu.not_later}, {"gaps", imu.gaps},
                    {"saturated", imu.saturated}, {"extrapolated", imu.extrapolated}};
  summary["remarks"] = remarks;
  return summary;
}

}  // namespace chasles::app
