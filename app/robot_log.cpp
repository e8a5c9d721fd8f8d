#include "robot_log.hpp"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/run_folder/run.hpp>

#include "calibration_report.hpp"
#include "run_landmarks.hpp"
#include "run_recording.hpp"
#include "run_state.hpp"
#include "summary.hpp"

namespace chasles::app {

RobotLog::RobotLog(Recording sensors, InertialRunSettings settings,
                   const InertialRunSettings& decided_settings, const Estimator& estimator)
    : sensors_(std::move(sensors)), settings_(std::move(settings)) {
  run_.name = sensors_.name;
  run_.extra_names = estimator.state_names();
  const std::vector<std::string> more =
      calibration_columns(decided_settings.filter, sensors_.cameras.size());
  run_.extra_names.insert(run_.extra_names.end(), more.begin(), more.end());
}

void RobotLog::add(const FeatureFrame& frame) {
  if (!first_frame_) first_frame_ = frame.time;
  last_frame_ = frame.time;
  ++frames_;
  spans_.add(frame);
}

void RobotLog::add(std::span<const Estimate> estimates) {
  for (const Estimate& e : estimates) {
    if (!start_seconds_ && first_frame_) {
      start_seconds_ = to_seconds(e.time - *first_frame_);
      initialised_seconds_ = to_seconds(*last_frame_ - *first_frame_);
      before_start_ = frames_ - 1;
    }
    if (e.in_map) {
      run_.in_map.push_back({.time = e.time,
                             .world_T_imu = e.in_map->map_T_imu,
                             .pose_covariance = e.in_map->covariance});
    }
    estimated_ += e.health == Health::kLost ? 0 : 1;
    zupt_frames_ += e.zero_velocity ? 1 : 0;
    if (e.health == Health::kDegraded && e.degradation != Degradation::kNone)
      ++degradations_[e.degradation];
    calibration_ = e.calibration;
    run_.states.push_back(run_state(e, sensors_.cameras));
  }
}

void RobotLog::write(const Estimator& estimator, const std::filesystem::path& folder) const {
  RecordedRun result;
  result.run = run_;
  result.report.estimator = estimator.report();
  const Past::Estimates past = estimator.past();
  result.run.landmarks = run_landmarks(past.landmarks, estimator.initial_landmarks());
  spans_.fill_in(estimator.in_state(), result.run.landmarks);
  for (const PastPose& pose : past.poses) {
    result.run.smoothed.push_back(
        {.time = pose.time, .world_T_imu = pose.map_T_imu, .pose_covariance = pose.covariance});
  }
  result.report.interrupted = true;  // no recording whose rest a check could look at
  result.start_seconds = start_seconds_;
  result.initialised_seconds = initialised_seconds_;
  result.coverage = {
      .estimated = std::min(frames_, estimated_), .frames = frames_, .before_start = before_start_};
  result.zupt_frames = zupt_frames_;
  result.degradations = degradations_;
  result.calibration = calibration_;
  nlohmann::ordered_json summary =
      summary_json(result, settings_, inertial_sensors(sensors_), sensors_);
  summary.erase("frontend");  // its totals are of a run by the command
  write_run(result.run, summary, folder);
}

}  // namespace chasles::app
