#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <chasles/base/constants.hpp>
#include <chasles/numeric/random.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

// Runs with sensor faults, on simulated tracks.

namespace chasles {
namespace {

using namespace test;

// The landmarks keep their numbers; their pixels are random.
Recording with_garbage(double from, double to) {
  Recording recording = simulate_inertial(short_hallway(), 0);
  const chasles::Random random = random_of_run(7, 0);
  std::uint64_t frames = 0;
  change_frames(recording, from, to, [&](FeatureFrame& frame) {
    std::uint32_t i = 0;
    ++frames;
    for (PixelObservation& o : frame.pixels) {
      o.pixel = {350 + 150 * random.normal(Stream::kOutlier, frames, i),
                 270 + 120 * random.normal(Stream::kOutlier, frames, i + 1)};
      i += 2;
    }
  });
  return recording;
}

TEST(InertialSessionFaults, GarbageForASecondIsRejectedAndDegrades) {
  const Recording recording = with_garbage(4, 5);
  InertialSession session = session_for(recording);
  const Estimates estimates = play(session, recording);
  expect_sound(estimates);
  EXPECT_EQ(session.report().resets, 0);
  int used = 0, rejected = 0;
  for (const Estimate& e : estimates) {
    if (e.time < after(recording, 4) || e.time >= after(recording, 5)) continue;
    used += e.used;
    rejected += e.rejected;
    if (e.time > after(recording, 4.5)) {
      EXPECT_EQ(e.health, Health::kDegraded);
    }
  }
  EXPECT_LT(used, 0.05 * rejected);
  EXPECT_LT(error_from(estimates, recording), 0.3);
}

TEST(InertialSessionFaults, AfterMuchGarbageItBeginsAnew) {
  const Recording recording = with_garbage(2, 6);
  InertialSession session = session_for(recording);
  const Estimates estimates = play(session, recording);
  expect_sound(estimates);
  // A start may be found in a window that still contains garbage; it does not last.
  EXPECT_GE(session.report().resets, 1);
  EXPECT_LE(session.report().resets, 2);
  EXPECT_TRUE(session.running());
  EXPECT_EQ(estimates.back().time, recording.frames.back().time);
  EXPECT_EQ(session.report().resets, std::ranges::count_if(estimates, [](const Estimate& e) {
              return e.health == Health::kLost;
            }));
  const auto lost = std::ranges::find(estimates, Health::kLost, &Estimate::health);
  const auto next = std::next(lost);
  ASSERT_NE(next, estimates.end());
  // It starts at the last known position, within the distance travelled in between.
  const double way = (next->world_T_imu.p - estimates.front().world_T_imu.p).norm();
  EXPECT_NEAR(way, 1.2 * 2, 0.5);
  EXPECT_GT(position_sigma(*next), 1.2 * 2);
  EXPECT_LT(error_from(estimates, recording, after(recording, 13)), 0.3);
  for (const MapLandmark& landmark : session.map_nav()) EXPECT_TRUE(landmark.p_world.allFinite());
}

// Rejected null-space updates count against the filter as well.
TEST(InertialSessionFaults, AfterMuchGarbageItBeginsAnewWithTracksAlone) {
  const Recording recording = with_garbage(2, 8);
  InertialSession session = session_for(recording, std::nullopt, tracks_alone());
  const Estimates estimates = play(session, recording);
  expect_sound(estimates);
  EXPECT_GE(session.report().resets, 1);
  EXPECT_LE(session.report().resets, 3);
  EXPECT_TRUE(session.running());
  EXPECT_LT(error_from(estimates, recording, after(recording, 15)), 0.5);
}

// A fifth of the tracks are always wrong; this is no reason to start again.
TEST(InertialSessionFaults, OutliersAreNoReasonToBeginAnew) {
  InertialScene scene = short_hallway();
  scene.settings.outlier_fraction = 0.2;
  const Recording recording = simulate_inertial(scene, 0);
  InertialSession session = session_for(recording);
  const Estimates estimates = play(session, recording);
  expect_sound(estimates);
  EXPECT_EQ(session.report().resets, 0);
  EXPECT_LT(error_from(estimates, recording), 0.5);
}

TEST(InertialSessionFaults, FramesThatAreNotLaterAreDroppedAndCounted) {
  const Recording recording = simulate_inertial(short_hallway(), 0);
  Recording disordered = recording;
  FeatureFrame late = recording.frames[100];
  disordered.frames.insert(disordered.frames.begin() + 201, late);                   // backwards
  disordered.frames.insert(disordered.frames.begin() + 302, recording.frames[300]);  // twice
  InertialSession plain = session_for(recording), session = session_for(disordered);
  const Estimates expected = play(plain, recording), estimates = play(session, disordered);
  EXPECT_EQ(session.report().dropped_frames, 2);
  EXPECT_EQ(session.report().resets, 0);
  ASSERT_EQ(estimates.size(), expected.size());
  EXPECT_EQ(estimates.back().world_T_imu.p, expected.back().world_T_imu.p);
}

TEST(InertialSessionFaults, AFrameFromTheFutureIsDroppedAndTheNextIsNot) {
  Recording recording = simulate_inertial(short_hallway(), 0);
  InertialSession session = session_for(recording);
  for (const ImuSample& sample : recording.imu) session.process(sample);
  EXPECT_TRUE(session.process(FeatureFrame{.time = recording.imu.back().time + from_seconds(3600)})
                  .empty());
  EXPECT_EQ(session.report().dropped_frames, 1);
  session.process(recording.frames.back());
  EXPECT_EQ(session.report().dropped_frames, 1);
}

TEST(InertialSessionFaults, AShortGapOfSamplesIsBridgedAndOnesThatAreNotNumbersAreLeftOut) {
  Recording recording = simulate_inertial(short_hallway(), 0);
  remove_samples(recording, 5, 5.2);
  recording.imu[700].specific_force_imu.y() = kNaN;
  recording.imu[900].angular_rate_imu.x() = std::numeric_limits<double>::infinity();
  InertialSession session = session_for(recording);
  const Estimates estimates = play(session, recording);
  expect_sound(estimates);
  EXPECT_EQ(session.report().resets, 0);
  EXPECT_EQ(session.report().imu.gaps, 1);
  EXPECT_EQ(session.report().imu.not_finite, 2);
  EXPECT_LT(error_from(estimates, recording), 0.3);
}

// The session screens the samples once, before the start as well as in all parts of the run.
TEST(InertialSessionFaults, WhatIsNoMeasurementCountsOnceInTheWholeRun) {
  Recording recording = simulate_inertial(short_hallway(), 0);
  for (const std::size_t k : {5u, 700u, 1500u}) recording.imu[k].specific_force_imu.y() = kNaN;
  remove_samples(recording, 6, 7);
  InertialSession session = session_for(recording);
  expect_sound(play(session, recording));
  EXPECT_EQ(session.report().resets, 1);
  EXPECT_EQ(session.report().imu.not_finite, 3);
}

TEST(InertialSessionFaults, WithoutSamplesForASecondItBeginsAnew) {
  Recording recording = simulate_inertial(short_hallway(), 0);
  remove_samples(recording, 6, 7);
  InertialSession session = session_for(recording);
  const Estimates estimates = play(session, recording);
  expect_sound(estimates);
  EXPECT_EQ(session.report().resets, 1);
  EXPECT_TRUE(session.running());
  EXPECT_EQ(estimates.back().time, recording.frames.back().time);
  // A dynamic initialisation from one second has new errors of scale and tilt: decimetres over this
  // distance.
  EXPECT_LT(error_from(estimates, recording, after(recording, 9)), 0.8);
  // It continues from the last position, within the distance travelled in between.
  const auto next = std::ranges::find_if(
      estimates, [&](const Estimate& e) { return e.time >= after(recording, 6.8); });
  ASSERT_NE(next, estimates.end());
  const auto last = std::prev(next);
  EXPECT_LT((next->world_T_imu.p - last->world_T_imu.p).norm(), 3);
  EXPECT_GT(position_sigma(*next), position_sigma(*last));
}

// A live sensor that fails: no further sample comes.
TEST(InertialSessionFaults, WhenTheSamplesEndTheFramesAreDropped) {
  Recording recording = simulate_inertial(short_hallway(), 0);
  remove_samples(recording, 6, 1e6);
  InertialSession session = session_for(recording);
  const Estimates estimates = play(session, recording);
  expect_sound(estimates);
  EXPECT_LE(estimates.back().time, after(recording, 6.5));
  EXPECT_GT(session.report().dropped_frames, 100);
}

TEST(InertialSessionFaults, OneAbsurdSampleIsBridged) {
  const Recording intact = simulate_inertial(short_hallway(), 0);
  InertialSession session = session_for(intact);
  const double error = error_from(play(session, intact), intact);
  for (const double absurd : {1e5, 1e160, 1e308}) {
    Recording recording = intact;
    recording.imu[700].specific_force_imu.setConstant(absurd);
    recording.imu[700].angular_rate_imu.setConstant(absurd);
    InertialSession spoilt = session_for(recording);
    const Estimates estimates = play(spoilt, recording);
    expect_sound(estimates);
    EXPECT_EQ(spoilt.report().resets, 0) << absurd;
    EXPECT_EQ(spoilt.report().imu.spikes, 1) << absurd;
    EXPECT_LT(error_from(estimates, recording), 1.5 * error) << absurd;
  }
}

TEST(InertialSessionFaults, TwoAbsurdSamplesEndThePartAndNotTheRun) {
  for (const double absurd : {1e5, 1e160, 1e308}) {
    Recording recording = simulate_inertial(short_hallway(), 0);
    for (const std::size_t k : {700u, 701u}) {
      recording.imu[k].specific_force_imu.setConstant(absurd);
      recording.imu[k].angular_rate_imu.setConstant(absurd);
    }
    InertialSession session = session_for(recording);
    const Estimates estimates = play(session, recording);
    expect_sound(estimates);
    EXPECT_GE(session.report().resets, 1) << absurd;
    EXPECT_TRUE(session.running()) << absurd;
    EXPECT_EQ(estimates.back().time, recording.frames.back().time);
    EXPECT_LT(error_from(estimates, recording, after(recording, 14)), 0.3) << absurd;
  }
}

}  // namespace
}  // namespace chasles
