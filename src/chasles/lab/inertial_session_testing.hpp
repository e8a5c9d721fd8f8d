#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/eval/ate.hpp>
#include <chasles/lab/trial.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/slam/inertial_session.hpp>

// What the tests of a whole run share.
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
                                   const std::optional<InertialStart>& start = std::nullopt) {
  InertialSensors sensors{.cameras = recording.cameras,
                          .noise = *recording.imu_noise,
                          .imu = {.convention = recording.imu_convention},
                          .pixel_sigma = recording.single_pixel_sigma.value_or(1)};
  return {{}, {}, std::move(sensors), start};
}

using Estimates = std::vector<InertialEstimate>;

inline Estimates play(InertialSession& session, const Recording& recording) {
  Estimates all;
  EventStream events(recording);
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) session.process(*sample);
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (!frame) continue;
    const Estimates some = session.process(*frame);
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

/// Of the estimates from that time on, after alignment by position and heading [m].
inline double error_from(const Estimates& estimates, const Recording& recording,
                         Time from = Time(0)) {
  Trajectory own, truth;
  for (const InertialEstimate& e : estimates) {
    const auto known = truth_at(recording.truth, e.time);
    if (!known || e.time < from) continue;
    own.push_back({.time = e.time, .pose = e.motion.nav_T_imu});
    truth.push_back({.time = e.time, .pose = *known});
  }
  if (own.size() < 3) return std::nan("");
  return absolute_error(associate(own, truth, Time(0)), Alignment::kPositionYaw).position_m.rmse;
}

inline void expect_sound(const Estimates& estimates) {
  for (std::size_t k = 0; k < estimates.size(); ++k) {
    const NavState& m = estimates[k].motion;
    EXPECT_TRUE(m.nav_T_imu.p.allFinite() && m.nav_T_imu.R.allFinite() && m.v_nav.allFinite() &&
                m.biases.allFinite() && m.covariance.allFinite())
        << "estimate " << k;
    if (k > 0) {
      EXPECT_GT(estimates[k].time, estimates[k - 1].time);
    }
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

inline double position_sigma(const InertialEstimate& e) {
  return std::sqrt(e.motion.covariance.block<3, 3>(3, 3).trace());
}

}  // namespace chasles::test
