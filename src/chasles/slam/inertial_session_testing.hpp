#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/eval/ate.hpp>
#include <chasles/lab/trial.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/slam/inertial_session.hpp>

// Shared by the tests of a whole run.
namespace chasles::test {

inline InertialScene short_hallway() {
  InertialScene scene = inertial_scene("hallway");
  scene.settings.hall_length = 12;
  scene.settings.hall_width = 8;
  scene.settings.sections = 2;
  return scene;
}

inline InertialScene short_turntable() {
  InertialScene scene = inertial_scene("turntable");
  scene.settings.revolutions = 0.6;
  return scene;
}

inline InertialSession session_for(const Recording& recording,
                                   const std::optional<InertialStart>& start = std::nullopt,
                                   const InertialSlamSettings& settings = {}) {
  InertialSensors sensors{.cameras = recording.cameras,
                          .noise = *recording.imu_noise,
                          .imu = {.convention = recording.imu_convention},
                          .pixel_sigma = recording.single_pixel_sigma.value_or(1)};
  return {settings, {}, std::move(sensors), start};
}

/// No landmark ever enters the state.
inline InertialSlamSettings tracks_alone() {
  InertialSlamSettings settings;
  settings.max_landmarks = settings.min_landmarks = 0;
  return settings;
}

using Estimates = std::vector<Estimate>;

inline Estimates play(InertialSession& session, const Recording& recording) {
  Estimates all;
  EventStream events(recording);
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) append(session.process(*sample), all);
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (frame) append(session.process(*frame), all);
  }
  return all;
}

/// RMS position error of the poses from that time on, after alignment by position and heading [m].
inline double error_from(const Trajectory& poses, const Trajectory& truth, Time from = Time(0)) {
  Trajectory own, known;
  for (const StampedPose& pose : poses) {
    const auto true_pose = pose_at(truth, pose.time);
    if (!true_pose || pose.time < from) continue;
    own.push_back(pose);
    known.push_back({.time = pose.time, .pose = *true_pose});
  }
  if (own.size() < 3) return std::nan("");
  return absolute_error(associate(own, known), Alignment::kPositionYaw).position_m.rmse;
}

inline double error_from(const Estimates& estimates, const Recording& recording,
                         Time from = Time(0)) {
  Trajectory own;
  for (const Estimate& e : estimates) {
    own.push_back({.time = e.time, .pose = e.world_T_imu});
  }
  return error_from(own, recording.truth, from);
}

inline bool is_finite(const Calibration& calibration) {
  bool finite =
      calibration.covariance.allFinite() && std::isfinite(calibration.time_offset.value_or(0));
  for (const SE3& imu_T_camera : calibration.imu_T_camera) {
    finite = finite && imu_T_camera.R.allFinite() && imu_T_camera.p.allFinite();
  }
  return finite;
}

/// All values finite, variances not negative, time later than `before`.
inline bool is_sound(const Estimate& e, const std::optional<Time>& before) {
  return e.world_T_imu.p.allFinite() && e.world_T_imu.R.allFinite() && e.v_world->allFinite() &&
         e.additive.allFinite() && e.covariance.allFinite() &&
         e.covariance.diagonal().minCoeff() > -1e-9 &&
         (!e.calibration || is_finite(*e.calibration)) && (!before || e.time > *before);
}

inline void expect_sound(const Estimates& estimates) {
  std::optional<Time> before;
  for (const Estimate& e : estimates) {
    EXPECT_TRUE(is_sound(e, before)) << "the estimate of " << e.time.count() << " ns";
    before = e.time;
  }
}

inline Time after(const Recording& recording, double seconds) {
  return recording.frames.front().time + from_seconds(seconds);
}

template <typename Change>
inline void change_frames(Recording& recording, double from, double to, Change&& change) {
  for (FeatureFrame& frame : recording.frames) {
    if (frame.time >= after(recording, from) && frame.time < after(recording, to)) change(frame);
  }
}

inline void remove_samples(Recording& recording, double from, double to) {
  std::erase_if(recording.imu, [&](const ImuSample& sample) {
    return sample.time > after(recording, from) && sample.time < after(recording, to);
  });
}

inline double position_sigma(const Estimate& e) {
  return std::sqrt(e.covariance.block<3, 3>(3, 3).trace());
}

}  // namespace chasles::test
