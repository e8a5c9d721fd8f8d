#include "drive.hpp"

#include <cmath>
#include <functional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/check/velocity_clock.hpp>
#include <chasles/slam/velocity_model.hpp>
#include <chasles/smooth/window/velocity_window.hpp>

#include "batch_report.hpp"
#include "frame_state.hpp"
#include "interrupt.hpp"
#include "live_view.hpp"
#include "progress.hpp"
#include "run_landmarks.hpp"
#include "stopwatch.hpp"
#include "summary.hpp"

namespace chasles::app {
namespace {

RunState drive_state(const Estimate& e, double milliseconds) {
  RunState state = frame_state(e, milliseconds);
  state.world_T_imu = e.world_T_imu;
  state.pose_covariance = e.pose_covariance;
  state.extra = {e.additive.begin(), e.additive.end()};
  state.extra_sigma = {e.additive_sigma.begin(), e.additive_sigma.end()};
  return state;
}

// What goes through a recording, event by event.
struct Estimating {
  std::function<void(const BodyVelocity&)> velocity;
  std::function<std::optional<Estimate>(const FeatureFrame&)> frame;
  std::function<std::vector<MapLandmark>()> map;
  std::function<std::vector<LandmarkId>()> in_state;
};

std::vector<LandmarkId> in_state_of(const VelocitySlam& slam) {
  std::vector<LandmarkId> ids;
  for (const Landmark& l : slam.filter().state().landmarks) ids.push_back(l.id);
  return ids;
}

void process_all(const Recording& recording, const Estimating& estimating,
                 const Interrupt& interrupt, bool quiet, LiveView& live, Drive& result) {
  Progress progress(recording.frames.size(), quiet);
  EventStream events(recording);
  Stopwatch frame_time;
  const auto map_so_far = [&] {
    std::vector<RunLandmark> map = run_landmarks(estimating.map());
    result.observation_spans.tell(estimating.in_state(), map);
    return map;
  };
  while (const auto event = events.next()) {
    if (const auto* velocity = std::get_if<BodyVelocity>(&*event)) {
      estimating.velocity(*velocity);
      continue;
    }
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (!frame) continue;  // an IMU sample beside the velocities
    result.observation_spans.add(*frame);
    const std::optional<Estimate> estimate = estimating.frame(*frame);
    if (!estimate) continue;
    result.run.states.push_back(drive_state(*estimate, 1e3 * frame_time.seconds()));
    result.estimates.push_back(*estimate);
    const double seconds = to_seconds(estimate->time - recording.frames.front().time);
    progress.show(result.run.states.size(), seconds);
    live.advance(result.run, result.run.states.size(), seconds, map_so_far);
    result.interrupted = interrupt.requested();
    // Nothing after a lost frame can be believed, and arithmetic on NaN is slow.
    if (result.interrupted || estimate->health == Health::kLost) return;
    frame_time = {};
  }
}

// What is known before the first event. All estimators have the motion model's additive states.
Drive prepared(const Recording& recording, const VelocitySlamSettings& settings,
               Trajectory velocities_alone) {
  Drive result;
  result.noise =
      choose_noise(settings, recording.velocities, recording.frames,
                   {.velocity = recording.velocity_sigma, .pixels = recording.pixel_sigma});
  result.run.name = recording.name;
  result.run.extra_names = additive_names(model_of(settings, result.noise));
  result.run.truth = recording.truth;
  result.run.plan = recording.plan;
  result.run.dead_reckoning = std::move(velocities_alone);
  result.run.georeference = recording.georeference;
  return result;
}

}  // namespace

double correct_clock(const VelocitySlamSettings& settings, Recording& recording) {
  double offset = settings.time_offset.value_or(0);
  if (!settings.time_offset) {
    const std::optional<VelocityClock> clock = velocity_clock(recording);
    const bool corrected = clock && clock->stands_out();
    if (corrected) offset = clock->offset;
    recording.remarks.push_back(
        !clock || !clock->believable()
            ? "time_offset=auto: the tracks do not tell how the velocities' clock stands against "
              "the frames': their stamps are taken as they are"
            : fmt::format(
                  "time_offset=auto: the velocities are stamped {} by {:.0f} +- {:.0f} ms against "
                  "the frames, as the tracks tell: their stamps are {}",
                  clock->offset > 0 ? "late" : "early", 1e3 * std::abs(clock->offset),
                  1e3 * clock->sigma, corrected ? "corrected" : "taken as they are"));
  }
  shift_velocities(recording, offset);
  return offset;
}

Drive drive(const Recording& recording, const VelocitySlamSettings& settings,
            const Interrupt& interrupt, bool quiet, Trajectory velocities_alone, LiveView& live) {
  Drive result = prepared(recording, settings, std::move(velocities_alone));
  result.slam = std::make_unique<VelocitySlam>(settings, recording.rig, result.noise);
  VelocitySlam& slam = *result.slam;
  result.run.stage_names = filter_stage_names();
  live.begin(result.run, known_json(settings, recording), recording.frames.size());
  process_all(recording,
              {.velocity = [&](const BodyVelocity& velocity) { slam.process(velocity); },
               .frame = [&](const FeatureFrame& frame) { return slam.process(frame); },
               .map = [&] { return slam.filter().map(); },
               .in_state = [&] { return in_state_of(slam); }},
              interrupt, quiet, live, result);
  result.run.landmarks = run_landmarks(slam.filter().map());
  result.observation_spans.tell(in_state_of(slam), result.run.landmarks);
  return result;
}

Drive slide(const Recording& recording, const VelocitySlamSettings& settings,
            const BatchSettings& batch, int keyframes, const Interrupt& interrupt, bool quiet,
            Trajectory velocities_alone, LiveView& live) {
  Drive result = prepared(recording, settings, std::move(velocities_alone));
  VelocityWindow window({.rig = recording.rig,
                         .settings = settings,
                         .noise = result.noise,
                         .velocities = {},
                         .frames = {}},
                        batch, keyframes);
  live.begin(result.run, known_json(settings, recording), recording.frames.size());
  process_all(recording,
              {.velocity = [&](const BodyVelocity& velocity) { window.process(velocity); },
               .frame = [&](const FeatureFrame& frame) { return window.process(frame); },
               .map = [&] { return window.map(); },
               .in_state = [&] { return window.in_window(); }},
              interrupt, quiet, live, result);
  for (RunState& state : result.run.states) state.stages.clear();
  if (!result.interrupted) window.check();
  result.window = window.report();
  result.run.landmarks = run_landmarks(window.map());
  result.observation_spans.tell(window.in_window(), result.run.landmarks);
  return result;
}

void smooth(const Recording& recording, const VelocitySlamSettings& settings,
            const BatchSettings& batch, Drive& drive) {
  const Stopwatch time;
  VelocityBatchResult result = chasles::smooth({.rig = recording.rig,
                                                .settings = settings,
                                                .noise = drive.noise,
                                                .velocities = recording.velocities,
                                                .frames = recording.frames,
                                                .initial = drive.estimates},
                                               batch);
  const double milliseconds = 1e3 * time.seconds() / static_cast<double>(result.estimates.size());
  drive.run.states.clear();
  drive.run.stage_names.clear();
  for (Estimate& e : result.estimates) {
    e.health = believable(result.report) ? Health::kOk : Health::kDegraded;
    drive.run.states.push_back(drive_state(e, milliseconds));
    drive.run.states.back().stages.clear();
  }
  drive.run.landmarks = run_landmarks(result.landmarks);
  drive.observation_spans.tell(std::nullopt, drive.run.landmarks);
  drive.batch = result.report;
}

Trajectory dead_reckoning(const Recording& recording) {
  VelocitySlamSettings settings;
  settings.mode = SlamMode::kLocalize;
  settings.velocity = VelocityRole::kInput;
  settings.hold = VelocityHold::kMidpoint;
  VelocitySlam slam(settings, recording.rig, VelocitySlamNoise{});
  Trajectory trajectory;
  EventStream events(recording);
  while (const auto event = events.next()) {
    if (const auto* velocity = std::get_if<BodyVelocity>(&*event)) {
      slam.process(*velocity);
    } else if (const auto* frame = std::get_if<FeatureFrame>(&*event)) {
      const Estimate e = slam.process(*frame);
      if (e.health == Health::kLost) break;
      trajectory.push_back({.time = e.time, .pose = e.world_T_imu});
    }
  }
  return trajectory;
}

}  // namespace chasles::app
