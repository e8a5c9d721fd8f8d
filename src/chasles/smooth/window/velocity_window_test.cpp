#include <algorithm>
#include <chrono>
#include <cmath>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/smooth/batch/exact_settings_testing.hpp>
#include <chasles/smooth/batch/velocity_testing.hpp>
#include <chasles/smooth/window/velocity_window.hpp>

namespace chasles {
namespace {

using test::drive_error;
using test::drive_scene;
using test::DriveScene;
using test::SmallDrive;

BatchSettings exact_velocity_window(LandmarkForm landmarks = LandmarkForm::kInverseDepth) {
  return test::exact_settings(landmarks);
}

struct WindowRun {
  std::vector<Estimate> estimates;
  std::vector<MapLandmark> map;
  WindowReport report;
};

std::vector<Estimate> feed(const VelocityBatchInput& input, VelocityWindow& window) {
  std::vector<Estimate> estimates;
  auto velocity = input.velocities.begin();
  for (const FeatureFrame& frame : input.frames) {
    for (; velocity != input.velocities.end() && velocity->time <= frame.time; ++velocity) {
      window.process(*velocity);
    }
    if (const auto e = window.process(frame)) estimates.push_back(*e);
  }
  return estimates;
}

WindowRun slide(const VelocityBatchInput& input, const BatchSettings& settings, int keyframes) {
  VelocityWindow window(input, settings, keyframes);
  WindowRun run;
  run.estimates = feed(input, window);
  window.check();
  run.report = window.report();
  run.map = window.map();
  return run;
}

class VelocityWindowOver : public test::OverCharts {
 protected:
  DriveScene scene(const SmallDrive& drive) const {
    DriveScene s = drive_scene(drive);
    s.input.settings.chart = std::string(chart().name);
    return s;
  }
};

TEST_P(VelocityWindowOver, OfTheWholeRecordingIsTheBatch) {
  const SmallDrive kinds[] = {
      {.frames = 6, .landmarks = 12},
      {.frames = 5, .scale = true, .rows = StereoRows::kMean, .samples_a_frame = 2, .seed = 2},
      {.frames = 5, .level = true, .landmarks = 12, .seed = 4},
      {.frames = 5,
       .velocity = VelocityRole::kInput,
       .rows = StereoRows::kAll,
       .landmarks = 12,
       .seed = 3}};
  for (const SmallDrive& kind : kinds) {
    const DriveScene s = scene(kind);
    for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
      const VelocityBatchResult batch = smooth(s.input, exact_velocity_window(landmarks));
      const WindowRun run = slide(s.input, exact_velocity_window(landmarks), kind.frames);
      ASSERT_EQ(run.estimates.size(), batch.estimates.size());
      const Estimate &e = run.estimates.back(), &b = batch.estimates.back();
      EXPECT_LT((e.world_T_imu.p - b.world_T_imu.p).norm(), 1e-6);
      EXPECT_LT(so3::log(e.world_T_imu.R * b.world_T_imu.R.transpose()).norm(), 1e-6);
      EXPECT_LT((e.additive - b.additive).norm(), 1e-6);
      EXPECT_LT(test::covariance_difference(e.pose_covariance(), b.pose_covariance()), 1e-4);
      EXPECT_LT((e.additive_sigma().cwiseQuotient(b.additive_sigma()).array() - 1).abs().maxCoeff(),
                1e-4);
      ASSERT_EQ(run.map.size(), batch.landmarks.size());
      for (const MapLandmark& l : batch.landmarks) {
        const auto found = std::ranges::find(run.map, l.id, &MapLandmark::id);
        ASSERT_NE(found, run.map.end());
        EXPECT_LT((found->p_world - l.p_world).norm(), 1e-5);
        EXPECT_LT(test::covariance_difference(found->covariance, l.covariance), 1e-4);
        EXPECT_EQ(found->observations, l.observations);
      }
    }
  }
}

// The last estimate uses all data, also those marginalised. The error of their fixed linearisation
// is small against the estimate's own sigma.
TEST_P(VelocityWindowOver, ThatMarginalisesHardlyDiffersFromTheBatch) {
  for (const bool level : {false, true}) {
    const DriveScene s = scene({.frames = 20, .level = level});
    const Estimate b = smooth(s.input, exact_velocity_window()).estimates.back();
    for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
      for (const int keyframes : {2, 4, 8}) {
        const WindowRun run = slide(s.input, exact_velocity_window(landmarks), keyframes);
        const Estimate& e = run.estimates.back();
        Vector6d d;
        d << so3::log(e.world_T_imu.R * b.world_T_imu.R.transpose()),
            e.world_T_imu.p - b.world_T_imu.p;
        EXPECT_LT(d.dot(b.pose_covariance().ldlt().solve(d)), 0.25)
            << name_of(landmarks) << keyframes;
        EXPECT_LT(test::covariance_difference(e.pose_covariance(), b.pose_covariance()), 0.1);
      }
    }
  }
}

TEST_P(VelocityWindowOver, KnowsHowWrongItIs) {
  double middle = 0, last = 0;
  int runs = 0;
  for (; runs < 40; ++runs) {
    const DriveScene s = scene({.frames = 16, .seed = 300 + static_cast<std::uint64_t>(runs)});
    const WindowRun run = slide(s.input, exact_velocity_window(), 5);
    const auto nees = [&](std::size_t k) {
      const Estimate& e = run.estimates[k];
      const Eigen::VectorXd d = drive_error(s.truth[k], e);
      return d.head<6>().dot(e.pose_covariance().ldlt().solve(d.head<6>()));
    };
    middle += nees(8);
    last += nees(15);
  }
  EXPECT_TRUE(test::is_chi2(middle, 6 * runs));
  EXPECT_TRUE(test::is_chi2(last, 6 * runs));
}

TEST_P(VelocityWindowOver, TheSameBytesEveryTime) {
  const DriveScene s = scene({.frames = 12});
  const WindowRun a = slide(s.input, {}, 4), b = slide(s.input, {}, 4);
  ASSERT_EQ(a.estimates.size(), b.estimates.size());
  for (std::size_t k = 0; k < a.estimates.size(); ++k) {
    EXPECT_EQ(a.estimates[k].world_T_imu.p, b.estimates[k].world_T_imu.p);
    EXPECT_EQ(a.estimates[k].pose_covariance(), b.estimates[k].pose_covariance());
  }
}

INSTANTIATE_TEST_SUITE_P(Charts, VelocityWindowOver, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

TEST(VelocityWindow, KnowsNothingOfWhatComesLater) {
  const DriveScene s = drive_scene({.frames = 14});
  VelocityBatchInput cut = s.input;
  cut.frames.resize(9);
  cut.velocities.resize(9);
  const WindowRun all = slide(s.input, {}, 4), half = slide(cut, {}, 4);
  ASSERT_EQ(half.estimates.size(), 9u);
  for (std::size_t k = 0; k < 9; ++k) {
    EXPECT_EQ(all.estimates[k].world_T_imu.p, half.estimates[k].world_T_imu.p);
    EXPECT_EQ(all.estimates[k].additive, half.estimates[k].additive);
  }
}

TEST(VelocityWindow, LeavesWrongPixelsOut) {
  for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    DriveScene s = drive_scene({.frames = 14});
    BatchSettings settings;
    settings.landmarks = landmarks;
    const WindowRun clean = slide(s.input, settings, 5);
    EXPECT_EQ(clean.report.gated, 0);
    // A first observation, and some later ones.
    s.input.frames[0].observations[0].pixels += Eigen::Vector4d(15, 5, 15, 5);
    for (const std::size_t k : {3u, 5u, 8u, 11u}) {
      s.input.frames[k].observations[k].pixels += Eigen::Vector4d(40, -25, 40, -25);
    }
    const WindowRun run = slide(s.input, settings, 5);
    EXPECT_GE(run.report.gated, 5) << name_of(landmarks);
    EXPECT_LT(run.report.gated, 12) << name_of(landmarks);
    EXPECT_LT((run.estimates.back().world_T_imu.p - clean.estimates.back().world_T_imu.p).norm(),
              0.03);
  }
}

// A landmark out of view for less than the window is the same one, unless batch.loops is false.
TEST(VelocityWindow, ALandmarkThatComesBackIsTheSameWhileItIsThere) {
  DriveScene s = drive_scene({.frames = 14});
  for (std::size_t k = 4; k < 8; ++k) {
    std::erase_if(s.input.frames[k].observations,
                  [](const StereoObservation& o) { return o.landmark < 110; });
  }
  BatchSettings settings;
  EXPECT_EQ(slide(s.input, settings, 10).report.landmarks, 20);
  EXPECT_EQ(slide(s.input, settings, 3).report.landmarks, 30);
  settings.loops = false;
  EXPECT_EQ(slide(s.input, settings, 10).report.landmarks, 30);
}

// Keyframes are marginalised for them, and instants are added. As inputs they do not constrain
// earlier states.
TEST(VelocityWindow, TakesVelocitiesAfterTheLastFrame) {
  DriveScene s = drive_scene({.frames = 12, .velocity = VelocityRole::kInput});
  for (int k = 0; k < 8;
       ++k) {  // for these, the prior has no information until the eighth frame leaves
    std::erase_if(s.input.frames[static_cast<std::size_t>(k)].observations,
                  [](const StereoObservation& o) { return o.landmark % 2 == 0; });
  }
  for (const int keyframes : {4, 20}) {
    VelocityWindow window(s.input, exact_velocity_window(), keyframes);
    feed(s.input, window);
    const std::vector<MapLandmark> before = window.map();
    ASSERT_GT(before.size(), 5U);
    for (int i = 1; i <= 5; ++i) {
      BodyVelocity late = s.input.velocities.back();
      late.time += i * std::chrono::milliseconds(20);
      window.process(late);
      const std::vector<MapLandmark> after = window.map();
      ASSERT_EQ(after.size(), before.size());
      for (const MapLandmark& l : before) {
        const auto found = std::ranges::find(after, l.id, &MapLandmark::id);
        ASSERT_NE(found, after.end());
        EXPECT_LT((found->p_world - l.p_world).norm(), 1e-6);
        EXPECT_LT(test::covariance_difference(found->covariance, l.covariance), 1e-6)
            << keyframes << ", " << i;
      }
    }
  }
}

TEST(VelocityWindow, TakesEveryNthFrame) {
  const DriveScene s = drive_scene({.frames = 13});
  BatchSettings settings;
  settings.frames_per_keyframe = 4;
  const WindowRun run = slide(s.input, settings, 2);
  ASSERT_EQ(run.estimates.size(), 4u);
  EXPECT_EQ(run.estimates[2].time, s.input.frames[8].time);
  EXPECT_LT(drive_error(s.truth[12], run.estimates[3]).segment<3>(3).norm(), 0.4);
}

TEST(VelocityWindowBadInput, IsRecoveredAndCounted) {
  DriveScene s = drive_scene({.frames = 12});
  s.input.frames[3].observations[0].pixels[1] = std::nan("");
  s.input.frames[5].observations.push_back(s.input.frames[5].observations[2]);
  s.input.frames[7].observations.clear();
  const WindowRun run = slide(s.input, {}, 4);
  EXPECT_EQ(run.report.unusable, 2);
  ASSERT_EQ(run.estimates.size(), 12u);
  EXPECT_LT(drive_error(s.truth.back(), run.estimates.back()).segment<3>(3).norm(), 0.4);
}

std::string rejection(const VelocityBatchInput& input, const BatchSettings& settings,
                      int keyframes) {
  try {
    slide(input, settings, keyframes);
  } catch (const Error& e) {
    return e.what();
  }
  return "nothing was rejected";
}

TEST(VelocityWindowBadInput, IsRejected) {
  const DriveScene s = drive_scene();
  const auto rejected = [&](const char* words, const auto& spoil) {
    VelocityBatchInput input = s.input;
    BatchSettings settings;
    int keyframes = 4;
    spoil(input, settings, keyframes);
    const std::string text = rejection(input, settings, keyframes);
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  rejected("2 or more", [](auto&, auto&, int& n) { n = 1; });
  rejected("observed twice", [](VelocityBatchInput& in, auto&, int&) {
    for (FeatureFrame& frame : in.frames) frame.observations.clear();
  });
  rejected("not finite", [](VelocityBatchInput& in, auto&, int&) {
    in.velocities[2].linear_imu.x() = std::nan("");
  });
  rejected("time runs backwards",
           [](VelocityBatchInput& in, auto&, int&) { std::swap(in.frames[2], in.frames[5]); });
  rejected("pixel_sigma", [](VelocityBatchInput& in, auto&, int&) { in.noise.update.v = 0; });
  rejected("velocity_walk",
           [](VelocityBatchInput& in, auto&, int&) { in.noise.motion.walk[4] = 0; });
  rejected("--mode slam",
           [](VelocityBatchInput& in, auto&, int&) { in.settings.mode = SlamMode::kMap; });
  rejected("batch.loss", [](auto&, BatchSettings& b, int&) { b.loss = BatchLoss{7}; });
  rejected("batch.landmarks", [](auto&, BatchSettings& b, int&) { b.landmarks = LandmarkForm{7}; });
  rejected("frames_per_keyframe",
           [](auto&, BatchSettings& settings, int&) { settings.frames_per_keyframe = 0; });
}

}  // namespace
}  // namespace chasles
