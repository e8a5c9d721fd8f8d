#include <algorithm>
#include <map>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/smooth/batch/exact_settings_testing.hpp>
#include <chasles/smooth/batch/smooth_testing.hpp>
#include <chasles/smooth/window/inertial_window.hpp>

namespace chasles {
namespace {

using test::motion_error;
using test::small_scene;
using test::SmallScene;

BatchSettings exact_window(LandmarkForm landmarks = LandmarkForm::kInverseDepth) {
  BatchSettings settings = test::exact_settings(landmarks);
  settings.min_parallax = 0;
  return settings;
}

class InertialWindow : public test::OverCharts {
 protected:
  std::string name() const { return std::string(chart().name); }
};

TEST_P(InertialWindow, OfTheWholeRecordingIsTheBatch) {
  for (const int cameras : {1, 2, 3}) {
    // The third time with points beside the cameras.
    SmallScene scene =
        small_scene({.frames = 8, .cameras = cameras, .landmarks = 16, .beside = cameras == 3});
    scene.input.match_sigma = 0.3;
    for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
      const InertialBatchResult batch = smooth(scene.input, name(), exact_window(landmarks));
      const InertialWindowResult window = slide(scene.input, name(), exact_window(landmarks), 8);
      ASSERT_EQ(window.estimates.size(), batch.estimates.size());
      const Estimate &w = window.estimates.back(), &b = batch.estimates.back();
      EXPECT_LT((w.world_T_imu.p - b.world_T_imu.p).norm(), 1e-6);
      EXPECT_LT(so3::log(w.world_T_imu.R * b.world_T_imu.R.transpose()).norm(), 1e-6);
      EXPECT_LT((*w.v_world - *b.v_world).norm(), 1e-6);
      EXPECT_LT((w.additive - b.additive).norm(), 1e-6);
      EXPECT_LT(test::covariance_difference(w.covariance, b.covariance), 1e-4);
      ASSERT_EQ(window.landmarks.size(), batch.landmarks.size());
      for (const MapLandmark& l : batch.landmarks) {
        const auto found = std::ranges::find(window.landmarks, l.id, &MapLandmark::id);
        ASSERT_NE(found, window.landmarks.end());
        EXPECT_LT((found->p_world - l.p_world).norm(), 1e-5);
        EXPECT_LT(test::covariance_difference(found->covariance, l.covariance), 1e-4);
      }
    }
  }
}

TEST_P(InertialWindow, KnowsHowWrongItIs) {
  double poses = 0, states = 0;
  int runs = 0;
  for (; runs < 30; ++runs) {
    const SmallScene scene =
        small_scene({.frames = 16, .seed = 500 + static_cast<std::uint64_t>(runs)});
    BatchSettings settings;
    settings.loss = BatchLoss::kNone;
    const InertialWindowResult window = slide(scene.input, name(), settings, 6);
    const Estimate& m = window.estimates.back();
    const Eigen::VectorXd e = motion_error(scene.truth.back().state, m);
    poses += e.head<6>().dot(m.covariance.topLeftCorner<6, 6>().ldlt().solve(e.head<6>()));
    states += e.dot(m.covariance.ldlt().solve(e));
  }
  EXPECT_TRUE(test::is_chi2(poses, 6 * runs));
  EXPECT_TRUE(test::is_chi2(states, 15 * runs));
}

TEST(InertialWindowRun, KnowsHowWrongItIsWithPointsBesideTheCamera) {
  double poses = 0;
  int runs = 0;
  for (; runs < 30; ++runs) {
    const SmallScene scene =
        small_scene({.frames = 16, .seed = 500 + static_cast<std::uint64_t>(runs), .beside = true});
    BatchSettings settings;
    settings.loss = BatchLoss::kNone;
    const InertialWindowResult window = slide(scene.input, "right-sen3", settings, 6);
    const Estimate& m = window.estimates.back();
    const Eigen::VectorXd e = motion_error(scene.truth.back().state, m);
    poses += e.head<6>().dot(m.covariance.topLeftCorner<6, 6>().ldlt().solve(e.head<6>()));
  }
  EXPECT_TRUE(test::is_chi2(poses, 6 * runs));
}

// Landmarks are observed for longer than the window, with a constant error of their matches.
TEST(InertialWindowRun, KnowsTheConstantErrorOfMatches) {
  double poses[2] = {0, 0};
  int runs = 0;
  for (; runs < 10; ++runs) {
    SmallScene scene = small_scene({.frames = 30,
                                    .cameras = 2,
                                    .landmarks = 16,
                                    .seed = 900 + static_cast<std::uint64_t>(runs)});
    const double sigma = 3;
    std::map<LandmarkId, Eigen::Vector2d> error;
    test::Random random(static_cast<std::uint64_t>(runs));
    for (FeatureFrame& frame : scene.input.frames) {
      for (PixelObservation& o : frame.pixels) {
        if (o.camera == 0) continue;
        const auto [at, fresh] = error.try_emplace(o.landmark, sigma * random.normal_vector(2));
        o.pixel += at->second;
      }
    }
    BatchSettings settings;
    settings.loss = BatchLoss::kNone;
    settings.gate = 0;
    for (const bool known : {false, true}) {
      scene.input.match_sigma = known ? sigma : 0;
      const Estimate m = slide(scene.input, "right-sen3", settings, 4).estimates.back();
      const Eigen::VectorXd e = motion_error(scene.truth.back().state, m);
      poses[known] += e.head<6>().dot(m.covariance.topLeftCorner<6, 6>().ldlt().solve(e.head<6>()));
    }
  }
  EXPECT_GT(poses[0], 5 * 6 * runs);
  EXPECT_LT(poses[1], 2 * 6 * runs);
}

INSTANTIATE_TEST_SUITE_P(Charts, InertialWindow, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

TEST(InertialWindowRun, KnowsNothingOfWhatComesLaterAndIsTheSameEveryTime) {
  const SmallScene scene = small_scene({.frames = 12});
  InertialBatchInput cut = scene.input;
  cut.frames.resize(8);
  cut.samples.resize(71);  // until the eighth frame
  const InertialWindowResult all = slide(scene.input, "right-sen3", {}, 4);
  const InertialWindowResult half = slide(cut, "right-sen3", {}, 4);
  ASSERT_EQ(half.estimates.size(), 8u);
  for (std::size_t k = 0; k < half.estimates.size(); ++k) {
    EXPECT_EQ(all.estimates[k].world_T_imu.p, half.estimates[k].world_T_imu.p);
    EXPECT_EQ(all.estimates[k].covariance, half.estimates[k].covariance);
  }
}

TEST(InertialWindowRun, FedAsItComesIsTheSame) {
  const SmallScene scene = small_scene({.frames = 12});
  const InertialWindowResult all = slide(scene.input, "right-sen3", {}, 4);
  chasles::InertialWindow window(scene.input, "right-sen3", {}, 4);
  std::vector<Estimate> motions;
  const auto keep = [&](const std::vector<Estimate>& some, const auto& when) {
    for (const Estimate& m : some) {
      EXPECT_LE(m.time, when);  // a sample at its time or later has arrived
      motions.push_back(m);
    }
  };
  // The samples up to a frame's time come before the frame, except for the third frame, which comes
  // early.
  auto sample = scene.input.samples.begin();
  for (std::size_t k = 0; k < scene.input.frames.size(); ++k) {
    const FeatureFrame& frame = scene.input.frames[k];
    const bool early = k == 2;
    for (; sample != scene.input.samples.end() &&
           (early ? sample->time < frame.time : sample->time <= frame.time);
         ++sample) {
      keep(window.process(*sample), sample->time);
    }
    keep(window.process(frame), frame.time);
    EXPECT_EQ(window.waiting(), early);
    EXPECT_EQ(motions.size(), early ? k : k + 1);
  }
  EXPECT_TRUE(window.finish().empty());
  window.check();
  ASSERT_EQ(motions.size(), all.estimates.size());
  for (std::size_t k = 0; k < motions.size(); ++k) {
    EXPECT_EQ(motions[k].world_T_imu.p, all.estimates[k].world_T_imu.p);
    EXPECT_EQ(motions[k].covariance, all.estimates[k].covariance);
  }
  EXPECT_EQ(window.map().size(), all.landmarks.size());
  EXPECT_EQ(window.gyroscope_bias(), motions.back().additive.tail<3>());
}

TEST(InertialWindowRun, WithoutMoreSamplesAFrameIsTakenAtTheEnd) {
  SmallScene scene = small_scene({.frames = 6});
  while (scene.input.samples.back().time >= scene.input.frames.back().time) {
    scene.input.samples.pop_back();
  }
  const InertialWindowResult result = slide(scene.input, "right-sen3", {}, 4);
  EXPECT_EQ(result.estimates.size(), 6u);
  EXPECT_EQ(result.estimates.back().time, scene.input.frames.back().time);
}

TEST(InertialWindowRun, LeavesWrongPixelsOutAndCountsBadInput) {
  SmallScene scene = small_scene({.frames = 16, .cameras = 2});
  const InertialWindowResult clean = slide(scene.input, "right-sen3", {}, 5);
  EXPECT_EQ(clean.report.gated, 0);
  for (const std::size_t k : {4u, 7u, 9u}) {
    scene.input.frames[k].pixels[3].pixel += Eigen::Vector2d(30, -25);
  }
  scene.input.frames[5].pixels[0].pixel[1] = std::nan("");
  scene.input.frames[6].pixels[1].camera = 7;
  std::swap(scene.input.frames[12], scene.input.frames[13]);  // the earlier one comes late
  const InertialWindowResult window = slide(scene.input, "right-sen3", {}, 5);
  EXPECT_GE(window.report.gated, 3);
  EXPECT_LT(window.report.gated, 10);
  EXPECT_EQ(window.report.unusable, 2);
  EXPECT_EQ(window.report.dropped_frames, 1);
  EXPECT_LT((window.estimates.back().world_T_imu.p - clean.estimates.back().world_T_imu.p).norm(),
            0.03);
}

TEST(InertialWindowRun, RejectsWhatItCannotUse) {
  const SmallScene scene = small_scene({.frames = 12});
  const auto rejected = [&](const char* words, const auto& spoil) {
    InertialBatchInput input = scene.input;
    BatchSettings settings;
    int keyframes = 4;
    spoil(input, settings, keyframes);
    std::string text = "nothing was rejected";
    try {
      slide(input, "standard", settings, keyframes);
    } catch (const Error& e) {
      text = e.what();
    }
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  rejected("2 or more", [](auto&, auto&, int& n) { n = 1; });
  rejected("observed twice", [](InertialBatchInput& in, auto&, int&) { in.frames.clear(); });
  rejected("observed twice", [](InertialBatchInput& in, auto&, int&) {
    for (FeatureFrame& frame : in.frames) frame.pixels.clear();
  });
  rejected("IMU samples", [](InertialBatchInput& in, auto&, int&) { in.samples.clear(); });
  rejected("IMU has no sample", [](InertialBatchInput& in, auto&, int&) {
    in.samples.erase(in.samples.begin() + 20, in.samples.begin() + 80);
  });
  rejected("camera", [](InertialBatchInput& in, auto&, int&) { in.cameras.clear(); });
  rejected("pixel_sigma", [](InertialBatchInput& in, auto&, int&) { in.pixel_sigma = 0; });
  rejected("noise_density",
           [](InertialBatchInput& in, auto&, int&) { in.noise.gyroscope_noise_density = 0; });
  rejected("batch.loss", [](auto&, BatchSettings& s, int&) { s.loss = BatchLoss{7}; });
  rejected("batch.landmarks", [](auto&, BatchSettings& s, int&) { s.landmarks = LandmarkForm{7}; });
}

TEST(InertialWindowRun, WidensByTheWalkOfTheKeyframesThatHaveLeft) {
  test::SmallScene scene = test::small_scene({.frames = 30, .noise = 0.1});
  test::let_walk(scene, 1);
  BatchSettings settings = exact_window();
  const InertialWindowResult plain = slide(scene.input, "right-sen3", settings, 6);
  settings.covariance_factor.reset();
  const InertialWindowResult wide = slide(scene.input, "right-sen3", settings, 6);
  ASSERT_EQ(wide.estimates.size(), plain.estimates.size());
  for (std::size_t k = 0; k < 6; ++k) {  // none has left
    EXPECT_EQ(wide.estimates[k].covariance, plain.estimates[k].covariance);
  }
  const double factor = wide.report.covariance_factor;
  EXPECT_GT(factor, 1.5);
  EXPECT_TRUE(
      wide.estimates.back().covariance.isApprox(factor * plain.estimates.back().covariance, 1e-14));
  EXPECT_TRUE(wide.landmarks.front().covariance.isApprox(
      factor * plain.landmarks.front().covariance, 1e-14));
  // There are no three views of a landmark.
  EXPECT_EQ(slide(scene.input, "right-sen3", settings, 2).report.covariance_factor, 1);
}

TEST(WindowReport, OfSeveralPartsHasTheFactorOfTheLast) {
  WindowReport sum, part;
  part.covariance_factor = 0.5;
  add(part, sum);
  EXPECT_EQ(sum.covariance_factor, 0.5);
}

}  // namespace
}  // namespace chasles
