#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/batch/smooth_testing.hpp>

// Recovered faults, errors, and ill-posed problems of a batch.
namespace chasles {
namespace {

using test::motion_error;
using test::small_scene;
using test::SmallScene;

std::string rejection(const InertialBatchInput& input, const BatchSettings& settings = {},
                      const std::string& chart = "standard") {
  try {
    smooth(input, chart, settings);
  } catch (const Error& e) {
    return e.what();
  }
  return "nothing was rejected";
}

// Pixels that agree with no landmark: an error, and no crash.
TEST(BatchGate, WhereNothingAgreesThereIsNoAnswer) {
  SmallScene scene = small_scene({.frames = 8});
  test::Random random(5);
  for (FeatureFrame& frame : scene.input.frames) {
    for (PixelObservation& o : frame.pixels) {
      o.pixel = {random.uniform(0, 640), random.uniform(0, 480)};
    }
  }
  BatchSettings settings;
  settings.gate = 0.01;
  EXPECT_NE(rejection(scene.input, settings).find("batch.gate"), std::string::npos);
}

TEST(BatchBadInput, IsRecoveredAndCounted) {
  SmallScene scene = small_scene({.frames = 12});
  auto& frames = scene.input.frames;
  frames[3].pixels[0].pixel.x() = std::nan("");
  frames[4].pixels[0].camera = 7;
  frames[4].pixels[1].camera = -1;
  frames[5].pixels.push_back(frames[5].pixels[2]);  // twice: neither is used
  frames.insert(frames.begin() + 8, frames[2]);     // out of order
  frames.push_back({.time = frames.back().time + std::chrono::seconds(5)});
  scene.input.samples[5].angular_rate_imu.y() = std::nan("");
  scene.input.samples.insert(scene.input.samples.begin() + 20, scene.input.samples[3]);
  const InertialBatchResult result = smooth(scene.input, "standard", {});
  EXPECT_EQ(result.report.unusable, 5);
  EXPECT_EQ(result.report.dropped_frames, 2);
  EXPECT_EQ(result.report.imu.not_finite, 1);
  EXPECT_EQ(result.report.imu.not_later, 1);
  EXPECT_LT(motion_error(scene.truth.back().state, result.estimates.back()).segment<3>(3).norm(),
            0.1);
}

TEST(BatchBadInput, NothingToEstimateFromIsRejected) {
  const SmallScene scene = small_scene();
  InertialBatchInput input = scene.input;
  input.frames.clear();
  EXPECT_NE(rejection(input).find("two frames"), std::string::npos);
  input = scene.input;
  for (FeatureFrame& frame : input.frames) frame.pixels.clear();
  EXPECT_NE(rejection(input).find("landmarks that are observed twice"), std::string::npos);
  input = scene.input;
  input.samples.clear();
  EXPECT_NE(rejection(input).find("IMU samples"), std::string::npos);
  input = scene.input;
  input.cameras.clear();
  EXPECT_NE(rejection(input).find("camera"), std::string::npos);
  input = scene.input;
  input.noise = {};
  EXPECT_NE(rejection(input).find("noise"), std::string::npos);
  input = scene.input;
  input.pixel_sigma = 0;
  EXPECT_NE(rejection(input).find("pixel_sigma"), std::string::npos);
  input = scene.input;
  input.start_covariance(7, 7) = -1;
  EXPECT_NE(rejection(input).find("covariance"), std::string::npos);
}

// No parallax, and no landmark that could be initialised.
TEST(BatchIllPosed, ACartesianLandmarkNeedsParallax) {
  const SmallScene scene = small_scene({.frames = 20, .noise = 0, .speed = 0, .turning = 0});
  BatchSettings settings;
  settings.landmarks = LandmarkForm::kCartesian;
  EXPECT_NE(rejection(scene.input, settings).find("parallax"), std::string::npos);
}

TEST(BatchBadInput, AGapOfTheImuIsNamed) {
  SmallScene scene = small_scene({.frames = 15});
  const Time from = scene.input.samples[30].time;
  std::erase_if(scene.input.samples, [&](const ImuSample& s) {
    return s.time > from && s.time < from + std::chrono::milliseconds(700);
  });
  EXPECT_NE(rejection(scene.input).find("no sample between"), std::string::npos);
}

TEST(BatchBadInput, UnknownNamesAreRejected) {
  const SmallScene scene = small_scene();
  EXPECT_NE(rejection(scene.input, {}, "polar").find("polar"), std::string::npos);
  const auto rejected = [&](const char* name, const BatchSettings& wrong) {
    const std::string text = rejection(scene.input, wrong);
    EXPECT_EQ(text.find(name), 0U) << text;
  };
  rejected("batch.landmarks: found the value 7", {.landmarks = LandmarkForm{7}});
  rejected("batch.loss: found the value 7", {.loss = BatchLoss{7}});
  rejected("batch.solver: found the value 7", {.solver = BatchSolver{7}});
  rejected("batch.chart: found 'other'", {.chart = "other"});
  BatchSettings settings;
  settings.frames_per_keyframe = 0;
  EXPECT_NE(rejection(scene.input, settings).find("frames_per_keyframe"), std::string::npos);
}

// One camera straight on at a constant speed: the speed is unobservable.
TEST(BatchIllPosed, NoExcitationIsNamedNotAnswered) {
  SmallScene scene = small_scene({.frames = 15, .shaking = 0, .turning = 0});
  scene.input.start_covariance.diagonal().segment<3>(6).setConstant(4);
  scene.input.start_covariance.diagonal().segment<3>(9).setConstant(0.16);
  scene.input.initial = scene.truth;
  const std::string text = rejection(scene.input);
  EXPECT_NE(text.find("ill-posed"), std::string::npos) << text;
  EXPECT_NE(text.find("velocity x with velocity y"), std::string::npos) << text;
  // With the start's own information, the problem has an answer.
  scene.input.start_covariance = small_scene().input.start_covariance;
  EXPECT_EQ(smooth(scene.input, "standard", {}).estimates.size(), 15u);
}

// One camera without translation: the depths are arbitrary, and so is the velocity.
TEST(BatchIllPosed, NoParallaxIsNamedNotAnswered) {
  SmallScene scene = small_scene({.frames = 100, .speed = 0, .turning = 0});
  scene.input.start_covariance.diagonal().segment<3>(9).setConstant(0.04);
  const std::string text = rejection(scene.input);
  EXPECT_NE(text.find("ill-posed"), std::string::npos) << text;
  EXPECT_NE(text.find("velocity"), std::string::npos) << text;
}

TEST(BatchFit, AMinimumThatDoesNotFitShows) {
  SmallScene scene = small_scene({.frames = 15, .cameras = 2});
  EXPECT_NEAR(smooth(scene.input, "standard", {}).report.cost_per_dof, 1, 0.2);
  scene.input.cameras[1].cam_T_imu.p.z() += 0.2;  // the stated extrinsics are wrong
  EXPECT_GT(smooth(scene.input, "standard", {}).report.cost_per_dof, 3);
}

TEST(BatchIllPosed, IsOnlyReportedWhereTheEstimatesDoNotSuffer) {
  // Two cameras determine that there is no motion, but do not separate gravity from the
  // accelerometer bias.
  const SmallScene scene = small_scene({.frames = 30, .cameras = 2, .speed = 0, .turning = 0});
  const InertialBatchResult result = smooth(scene.input, "standard", {});
  ASSERT_FALSE(result.report.unobservable.empty());
  for (const std::string& name : result.report.unobservable) {
    EXPECT_EQ(name.find("velocity"), std::string::npos) << name;
  }
  EXPECT_TRUE(smooth(small_scene({.frames = 30, .cameras = 2}).input, "standard", {})
                  .report.unobservable.empty());
}

}  // namespace
}  // namespace chasles
