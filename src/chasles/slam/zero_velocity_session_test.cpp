#include <map>

#include <chasles/eval/chi2.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

// Zero-velocity updates, with a covered lens and with images.

namespace chasles {
namespace {

using namespace test;

constexpr double kStandstill = 12;

Recording static_hallway(std::uint64_t run) {
  InertialScene scene = short_hallway();
  scene.settings.rest_duration = kStandstill;
  scene.settings.start_duration = 1;
  scene.settings.sections = 1;
  return simulate_inertial(scene, run);
}

struct Ending {
  double position_error = 0, position_sigma = 0, yaw_sigma = 0;
  int zero_velocity = 0;
};

// The last estimate before the walk begins, of a run with the lens covered from 3 s on.
Ending covered(const InertialSlamSettings& settings) {
  Recording recording = static_hallway(0);
  change_frames(recording, 3, kStandstill, [](FeatureFrame& frame) { frame.pixels.clear(); });
  const InertialStart start = draw_start(recording, settings, 1, 0);
  InertialSlam slam(settings, recording.cameras, *recording.imu_noise,
                    {.convention = recording.imu_convention}, 1, start);
  Ending ending;
  EventStream events(recording);
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) slam.process(*sample);
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (!frame || frame->time < start.time) continue;
    if (frame->time > after(recording, kStandstill - 0.1)) break;
    const Estimate e = slam.process(*frame);
    const auto truth = pose_at(recording.truth, e.time);
    ending.position_error = (e.world_T_imu.p - truth->p).norm();
    ending.position_sigma = position_sigma(e);
    ending.yaw_sigma = std::sqrt(e.covariance(2, 2));
    ending.zero_velocity += e.zero_velocity ? 1 : 0;
  }
  return ending;
}

TEST(Standstill, HoldsThePoseThroughACoveredLens) {
  const Ending held = covered({});
  InertialSlamSettings without;
  without.zupt_velocity_sigma = 0;
  const Ending adrift = covered(without);
  EXPECT_GT(held.zero_velocity, 300);
  EXPECT_EQ(adrift.zero_velocity, 0);
  EXPECT_LT(held.position_error, 0.02);
  EXPECT_LT(held.position_sigma, 0.03);
  EXPECT_GT(adrift.position_error, 10 * held.position_error);
  EXPECT_GT(adrift.position_sigma, 10 * held.position_sigma);
  EXPECT_GT(adrift.yaw_sigma, held.yaw_sigma);
}

// Where the depths are not observable, noise moves assumed ones beyond infinity. The landmarks are
// kept.
TEST(Standstill, LosesNoLandmarkWhoseDepthIsGuessed) {
  const Recording recording = static_hallway(0);
  InertialSlamSettings unaware;
  unaware.zupt_velocity_sigma = 0;
  InertialSession session = session_for(recording, std::nullopt, unaware);
  int frames = 0;
  for (const Estimate& e : play(session, recording)) {
    if (e.time < after(recording, 5) || e.time > after(recording, kStandstill - 0.5)) continue;
    ++frames;
    EXPECT_GE(e.used, e.in_state - 2) << to_seconds(e.time);
    EXPECT_GE(e.in_state, 10);
  }
  EXPECT_GT(frames, 100);
}

// Mean NEES of the pose over ten runs, in the last second of the standstill and at the end of the
// walk.
struct MeanNees {
  double at_standstill = 0, at_end = 0;
};

constexpr int kRuns = 10;

template <typename Change>
MeanNees mean_nees(const Change& change) {
  MeanNees mean;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    Recording recording = static_hallway(run);
    change(recording);
    const Trial trial = run_trial({.name = "standstill", .settings = {}}, recording,
                                  draw_start(recording, {}, 1, run));
    EXPECT_FALSE(trial.diverged);
    double sum = 0;
    int count = 0;
    for (const TrialPoint& point : trial.points) {
      if (point.seconds > kStandstill - 1 && point.seconds < kStandstill) {
        sum += point.nees_pose;
        ++count;
      }
    }
    mean.at_standstill += sum / count / kRuns;
    mean.at_end += trial.points.back().nees_pose / kRuns;
  }
  return mean;
}

TEST(Standstill, KeepsTheFilterConsistent) {
  const MeanNees mean = mean_nees([](Recording&) {});
  EXPECT_LT(mean.at_standstill, chi2_quantile(0.999, 6 * kRuns) / kRuns);
  EXPECT_LT(mean.at_end, chi2_quantile(0.999, 6 * kRuns) / kRuns);
  EXPECT_GT(mean.at_end, chi2_quantile(0.001, 6 * kRuns) / kRuns);
}

// Without motion, a tracked patch has the same error in every image. Eleven seconds of images,
// after the second in which the standstill is detected, contain no more information than one image.
TEST(Standstill, DoesNotCountTheSameErrorAgainAndAgain) {
  const MeanNees mean = mean_nees([](Recording& recording) {
    std::map<LandmarkId, Eigen::Vector2d> first;
    change_frames(recording, 1, kStandstill, [&](FeatureFrame& frame) {
      for (PixelObservation& o : frame.pixels) {
        o.pixel = first.emplace(o.landmark, o.pixel).first->second;
      }
    });
  });
  EXPECT_LT(mean.at_end, chi2_quantile(0.999, 6 * kRuns) / kRuns);
}

TEST(Standstill, IsNeverSaidOfAWalk) {
  const Recording recording = simulate_inertial(short_hallway(), 0);
  InertialSession session = session_for(recording);
  for (const Estimate& e : play(session, recording)) EXPECT_FALSE(e.zero_velocity);
}

}  // namespace
}  // namespace chasles
