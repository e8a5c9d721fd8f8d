#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include <chasles/slam/inertial_session_testing.hpp>

// Whole runs, on simulated tracks.

namespace chasles {
namespace {

using namespace test;

TEST(InertialSession, FindsItsStartAndAgreesWithTheTruth) {
  for (const InertialScene& scene : {short_hallway(), short_turntable()}) {
    const Recording recording = simulate_inertial(scene, 0);
    InertialSession session = session_for(recording);
    EXPECT_FALSE(session.running());
    const Estimates estimates = play(session, recording);
    EXPECT_TRUE(session.running());
    EXPECT_EQ(session.report().resets, 0);
    EXPECT_EQ(session.report().dropped_frames, 0);
    EXPECT_TRUE(session.requirements().empty());
    EXPECT_GT(estimates.size() + 60, recording.frames.size()) << scene.settings.name;
    EXPECT_LT(error_from(estimates, recording), 0.4) << scene.settings.name;
    EXPECT_GT(session.gyroscope_bias().norm(), 0);
    expect_sound(estimates);
  }
}

TEST(InertialSession, WithAGivenStartItIsTheFilterItself) {
  const Recording recording = simulate_inertial(short_hallway(), 0);
  const InertialStart start = draw_start(recording, {}, 1, 0);
  InertialSession session = session_for(recording, start);
  const Estimates estimates = play(session, recording);
  const Trial trial = run_trial({.name = "filter", .settings = {}}, recording, start);
  ASSERT_EQ(estimates.size(), trial.estimate.size());
  for (std::size_t k = 0; k < estimates.size(); ++k) {
    EXPECT_EQ(estimates[k].time, trial.estimate[k].time);
    EXPECT_EQ(estimates[k].world_T_imu.p, trial.estimate[k].pose.p);
    EXPECT_EQ(estimates[k].world_T_imu.R, trial.estimate[k].pose.R);
    EXPECT_EQ(estimates[k].nis, trial.points[k].nis);
  }
  EXPECT_FALSE(session.map_nav().empty());
}

std::ptrdiff_t degraded_frames(const Estimates& estimates) {
  return std::ranges::count(estimates, Health::kDegraded, &Estimate::health);
}

// A filter that works with tracks alone is not reported as starved, not even at the beginning, when
// no track has made an update yet. It is degraded only where any filter is: at the end of a
// corridor, where there are no points.
TEST(InertialSession, LivesOnTracksAlone) {
  for (const InertialScene& scene : {inertial_scene("hallway"), short_turntable()}) {
    const Recording recording = simulate_inertial(scene, 0);
    InertialSession usual = session_for(recording);
    InertialSession session = session_for(recording, std::nullopt, tracks_alone());
    const Estimates estimates = play(session, recording);
    EXPECT_EQ(session.report().resets, 0) << scene.settings.name;
    EXPECT_LT(error_from(estimates, recording), 0.5) << scene.settings.name;
    EXPECT_LE(degraded_frames(estimates), degraded_frames(play(usual, recording)) + 20);
    expect_sound(estimates);
  }
}

TEST(InertialSession, AGivenStartWithoutSamplesIsGivenUp) {
  const Recording recording = simulate_inertial(short_hallway(), 0);
  InertialStart start = draw_start(recording, {}, 1, 0);
  start.time -= from_seconds(2);
  InertialSession session = session_for(recording, start);
  const Estimates estimates = play(session, recording);
  EXPECT_EQ(session.report().resets, 1);
  EXPECT_TRUE(session.running());
  EXPECT_LT(error_from(estimates, recording), 0.3);
}

TEST(InertialSession, WithoutObservationsItIsDegradedAndLessCertainAndRecovers) {
  Recording recording = simulate_inertial(short_hallway(), 0);
  change_frames(recording, 5, 8, [](FeatureFrame& frame) { frame.pixels.clear(); });
  InertialSession session = session_for(recording);
  const Estimates estimates = play(session, recording);
  expect_sound(estimates);
  double before = 0, latest = 0;
  for (const Estimate& e : estimates) {
    if (e.time < after(recording, 5)) before = position_sigma(e);
    if (e.time > after(recording, 6) && e.time < after(recording, 8)) {
      EXPECT_EQ(e.health, Health::kDegraded);
      EXPECT_GT(position_sigma(e), latest);
      latest = position_sigma(e);
    }
    // A second after the turn, where the scene itself has almost no points.
    if (e.time > after(recording, 11) && e.time < after(recording, 14)) {
      EXPECT_EQ(e.health, Health::kOk);
    }
  }
  EXPECT_GT(latest, 1.5 * before);
  EXPECT_EQ(session.report().resets, 0);
  EXPECT_LT(error_from(estimates, recording), 1);
}

TEST(InertialSession, WithoutAStartItSaysWhatWasMissing) {
  Recording recording = simulate_inertial(short_hallway(), 0);
  change_frames(recording, 0, 1e6, [](FeatureFrame& frame) { frame.pixels.clear(); });
  InertialSession session = session_for(recording);
  EXPECT_TRUE(play(session, recording).empty());
  EXPECT_FALSE(session.running());
  EXPECT_NEAR(session.waited(),
              to_seconds(recording.frames.back().time - recording.frames.front().time), 1e-9);
  ASSERT_FALSE(session.requirements().empty());
  EXPECT_FALSE(all_met(session.requirements()));
  const std::string why = why_not_initialised(session.waited(), session.requirements());
  EXPECT_NE(why.find("frames with observations and IMU samples around them 0 of at least 5"),
            std::string::npos)
      << why;
}

TEST(InertialSession, OfNothingComesNothing) {
  const Recording recording = simulate_inertial(short_hallway(), 0);
  InertialSession session = session_for(recording);
  EXPECT_EQ(session.waited(), 0);
  EXPECT_TRUE(session.map_nav().empty());
  EXPECT_EQ(why_not_initialised(session.waited(), session.requirements()),
            "not initialised after 0 s: IMU samples 0 of at least 1");
  for (const FeatureFrame& frame : recording.frames) EXPECT_TRUE(session.process(frame).empty());
  EXPECT_EQ(session.report().dropped_frames, static_cast<int>(recording.frames.size()));
  EXPECT_FALSE(session.running());
  EXPECT_EQ(session.report().imu.used, 0);
}

}  // namespace
}  // namespace chasles
