#include <algorithm>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include <chasles/base/free_memory.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/pipeline/truth.hpp>
#include <chasles/session/recognition_report.hpp>
#include <chasles/session/run_landmarks.hpp>
#include <chasles/session/run_recorder.hpp>
#include <chasles/session/run_state.hpp>

namespace chasles {
namespace {

std::vector<std::string> stage_names(bool front_end) {
  std::vector<std::string> names = {"propagation", "update", "landmarks"};
  if (front_end) names.insert(names.begin(), "front_end");
  return names;
}

// In milliseconds, in the order of stage_names().
std::vector<double> stages(const StageSeconds& s, std::optional<double> front_end_seconds) {
  std::vector<double> all = {1e3 * s.propagation, 1e3 * s.update, 1e3 * s.landmarks};
  if (front_end_seconds) all.insert(all.begin(), 1e3 * *front_end_seconds);
  return all;
}

}  // namespace

RunRecorder::RunRecorder(const Recording& recording, const Estimator& estimator, Options options)
    : recording_(recording), estimator_(estimator), options_(std::move(options)) {
  Run& run = result_.run;
  run.name = recording.name;
  run.extra_names = estimator.state_names();
  run.extra_names.insert(run.extra_names.end(), options_.calibration_columns.begin(),
                         options_.calibration_columns.end());
  if (options_.has_stages) run.stage_names = stage_names(recording.images != nullptr);
  run.truth = recording.truth;
  run.pairing = recording.pairing;
  run.plan = recording.plan;
  run.georeference = recording.georeference;
  run.dead_reckoning = std::move(options_.dead_reckoning);
  run.states.reserve(frame_count(recording));  // to grow would have them twice
  result_.has_prior_map = options_.prior_map.has_value();
  if (options_.realtime) result_.realtime = RealtimeFigures{.speed = *options_.realtime};
}

Run RunRecorder::header() const {
  Run header = result_.run;
  if (!options_.truth_is_comparable) header.truth.clear();
  return header;
}

LiveMap RunRecorder::live_map() const {
  return_free_memory();  // the whole path and map take much
  const nlohmann::ordered_json known =
      recognition_json(estimator_.report(), result_.run, result_.has_prior_map);
  return {.landmarks = landmarks(estimator_.whole_map()),
          .known = json_text(known),
          .prior_map = result_.run.prior_map};
}

void RunRecorder::on_frame(const FeatureFrame& frame) {
  if (!first_frame_) first_frame_ = frame.time;
  latest_frame_ = frame.time;
  ++frames_;
  spans_.add(frame);
}

void RunRecorder::on_estimate(const Estimate& e, const EstimateTiming& timing) {
  if (!result_.start_seconds && first_frame_) note_start(e.time);
  if (e.in_map) note_place(e.time, *e.in_map);
  estimated_ += e.health == Health::kLost ? 0 : 1;
  result_.zupt_frames += e.zero_velocity ? 1 : 0;
  result_.calibration = e.calibration;
  result_.scale_sigma = e.scale_sigma;
  if (result_.realtime && timing.latency) result_.realtime->latency.push_back(*timing.latency);
  RunState& state = add_state(e, timing.seconds);
  if (!options_.has_stages || !e.seconds) return;
  state.stages =
      stages(*e.seconds, recording_.images ? std::optional(timing.frontend_seconds) : std::nullopt);
}

void RunRecorder::note_start(Time first_estimate) {
  result_.start_seconds = recorded_seconds(first_estimate);
  result_.initialised_seconds = recorded_seconds(latest_frame_);
  result_.coverage.before_start = frames_ - 1;
}

void RunRecorder::note_place(Time time, const PoseInMap& place) {
  result_.run.in_map.push_back(
      {.time = time, .world_T_imu = place.map_T_imu, .pose_covariance = place.covariance});
  std::optional<MapSketch>& map = result_.run.prior_map;
  if (!map) map = options_.prior_map.value_or(MapSketch{});
  map->world_T_map = place.world_T_map;
}

void RunRecorder::on_smoothed(std::span<const Estimate> estimates, double seconds) {
  result_.run.states.clear();
  result_.run.stage_names.clear();
  result_.scale_sigma.reset();  // that of the filter from which the batch starts
  sums_ = {};
  for (const Estimate& e : estimates) {
    result_.calibration = e.calibration;
    add_state(e, seconds / static_cast<double>(estimates.size()));
  }
}

RunState& RunRecorder::add_state(const Estimate& e, double seconds) {
  add_to_sums(e);
  result_.run.states.push_back(run_state(e, recording_.cameras));
  result_.run.states.back().milliseconds = 1e3 * seconds;
  return result_.run.states.back();
}

// Only a run that starts at the truth has the world of the truth.
void RunRecorder::add_to_sums(const Estimate& e) {
  const double nees = options_.truth_chart && e.v_world
                          ? state_nees(*options_.truth_chart, recording_, e)
                          : std::nan("");
  if (std::isfinite(nees)) {
    sums_.nees_state += nees;
    ++sums_.nees_count;
  }
  if (e.health == Health::kDegraded && e.degradation != Degradation::kNone) {
    ++sums_.degradations[e.degradation];
  }
  sums_.products += e.innovation_products;
  sums_.squares += e.innovation_squares;
}

void RunRecorder::report_sums() {
  result_.degradations = sums_.degradations;
  if (sums_.nees_count > 0) result_.nees_state = sums_.nees_state / sums_.nees_count;
  if (sums_.squares > 0) result_.innovation_correlation = sums_.products / sums_.squares;
}

std::vector<RunLandmark> RunRecorder::landmarks(const EstimatedMap& whole) const {
  std::vector<RunLandmark> all = run_landmarks(whole.landmarks, whole.initial);
  spans_.fill_in(whole.in_state, all);
  return all;
}

RecordedRun RunRecorder::finish(RunReport report) {
  if (result_.realtime) result_.realtime->frames = report.played;
  FrameCoverage& coverage = result_.coverage;
  coverage.frames = report.interrupted ? frames_ : frame_count(recording_);
  coverage.estimated = std::min(
      coverage.frames, estimated_ * static_cast<std::size_t>(options_.frames_per_estimate));
  result_.report = std::move(report);
  return_free_memory();
  const EstimatedMap whole = estimator_.whole_map();
  return_free_memory();  // what the smoothing took
  result_.run.landmarks = landmarks(whole);
  result_.run.smoothed.reserve(whole.poses.size());
  for (const PastPose& pose : whole.poses) {
    result_.run.smoothed.push_back(
        {.time = pose.time, .world_T_imu = pose.map_T_imu, .pose_covariance = pose.covariance});
  }
  report_sums();
  return std::move(result_);
}

}  // namespace chasles
