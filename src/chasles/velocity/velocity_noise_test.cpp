#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/velocity/velocity_model.hpp>
#include <chasles/velocity/velocity_noise.hpp>

namespace chasles {
namespace {

constexpr double kPeriod = 0.1;

std::vector<FeatureFrame> frames_with_rows(double sigma, double offset) {
  test::Random random(5);
  std::vector<FeatureFrame> frames(100);
  LandmarkId id = 0;
  for (FeatureFrame& frame : frames) {
    for (int i = 0; i < 20; ++i) {
      const double v = 100 + i;
      frame.observations.push_back({.landmark = id++,
                                    .pixels = {300, v + sigma * random.normal() + offset, 280,
                                               v + sigma * random.normal()}});
    }
  }
  return frames;
}

std::vector<BodyVelocity> drive(double linear_sigma, double angular_sigma) {
  test::Random random(7);
  std::vector<BodyVelocity> velocities;
  for (int i = 0; i < 1000; ++i) {
    velocities.push_back(
        {.time = from_seconds(kPeriod * i),
         .linear_imu = Eigen::Vector3d(8, 0, 0) + linear_sigma * random.normal_vector(3),
         .angular_imu = angular_sigma * random.normal_vector(3)});
  }
  return velocities;
}

TEST(RowDisagreement, IsTheSpreadOfRowsThatShouldAgreeWhateverTheirConstantDifference) {
  EXPECT_NEAR(row_disagreement(frames_with_rows(0.5, 0)), 0.5 * std::sqrt(2), 0.05);
  EXPECT_NEAR(row_disagreement(frames_with_rows(0.5, 3)), 0.5 * std::sqrt(2), 0.05);
}

TEST(RowDisagreement, HasAFloorForTrackersThatForceEqualRows) {
  EXPECT_EQ(row_disagreement(frames_with_rows(0, 0)), 0.2);
  EXPECT_EQ(row_disagreement({}), 0.2);
}

TEST(ChooseNoise, MeasuresWhatNobodySays) {
  const auto velocities = drive(0.5, 0.05);
  const VelocitySlamNoise noise = choose_noise({}, velocities, frames_with_rows(0.3, 0), {});
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(noise.motion.sample_sigma[axis], 0.05, 0.01);
    EXPECT_NEAR(noise.motion.sample_sigma[3 + axis], 0.5, 0.1);
  }
  EXPECT_GT(noise.gyro_bias_sigma, 0);
  EXPECT_GT(noise.update.disparity, noise.initialisation.disparity);
}

// Data without visible noise still have constant errors (docs/noise.md).
TEST(ChooseNoise, TakesNoSampleForExact) {
  const std::vector<BodyVelocity> steady = drive(0, 0);
  const Vector6d least = (Vector6d() << 5e-4, 5e-4, 5e-4, 0.1, 0.1, 0.1).finished();
  EXPECT_EQ(choose_noise({}, steady, {}, {}).motion.sample_sigma, least);
}

TEST(ChooseNoise, PrefersTheRecordingToItsEstimate) {
  StatedNoise stated;
  stated.velocity = BodyVelocitySigma{.linear = {1, 2, 3}, .angular = {4, 5, 6}};
  stated.pixels = Eigen::Vector4d(3, 1, 4, 1);
  const VelocitySlamNoise noise =
      choose_noise({}, drive(0.5, 0.05), frames_with_rows(0.3, 0), stated);
  EXPECT_EQ(noise.motion.sample_sigma, (Vector6d() << 4, 5, 6, 1, 2, 3).finished());
  EXPECT_DOUBLE_EQ(noise.initialisation.u, 2.5);        // of (uL + uR)/2
  EXPECT_DOUBLE_EQ(noise.initialisation.disparity, 5);  // of uL - uR
  EXPECT_DOUBLE_EQ(noise.update.disparity, 5);
}

TEST(ChooseNoise, PrefersTheSettingsToAnything) {
  VelocitySlamSettings settings;
  settings.velocity_sigma = 0.7;
  settings.rate_sigma = 0.07;
  settings.velocity_walk = 2;
  settings.rate_walk = 0.2;
  settings.pixel_sigma = 1.5;
  settings.disparity_sigma = 0.9;
  settings.disparity_inflation = 3;
  settings.gyro_bias_sigma = 0.01;
  settings.gyro_bias_walk = 1e-4;
  StatedNoise stated;
  stated.velocity = BodyVelocitySigma{.linear = {1, 2, 3}, .angular = {4, 5, 6}};
  stated.pixels = Eigen::Vector4d(3, 1, 4, 1);
  const VelocitySlamNoise noise = choose_noise(settings, {}, {}, stated);
  EXPECT_EQ(noise.motion.sample_sigma, (Vector6d() << 0.07, 0.07, 0.07, 0.7, 0.7, 0.7).finished());
  EXPECT_EQ(noise.motion.walk, (Vector6d() << 0.2, 0.2, 0.2, 2, 2, 2).finished());
  EXPECT_EQ(noise.initialisation.u, 1.5);
  EXPECT_EQ(noise.initialisation.v, 1.5);
  EXPECT_EQ(noise.initialisation.disparity, 0.9);
  EXPECT_DOUBLE_EQ(noise.update.disparity, 2.7);
  EXPECT_EQ(noise.gyro_bias_sigma, 0.01);
  EXPECT_EQ(noise.motion.gyro_bias_walk, 1e-4);
}

VelocitySlamSettings along(VelocityAxes axes) {
  VelocitySlamSettings settings;
  settings.velocity_axes = axes;
  return settings;
}

TEST(ChooseNoise, EstimatesTheAxesOfVelocitiesUnlessTheyAreGiven) {
  std::vector<BodyVelocity> hills;
  for (int k = 0; k < 300; ++k) {
    const double t = 0.1 * k, slope = 0.04 * std::sin(t);
    hills.push_back({.time = from_seconds(t),
                     .linear_imu = {9 * std::cos(slope), 0, 9 * std::sin(slope)},
                     .angular_imu = {0, -0.04 * std::cos(t), 0}});
  }
  EXPECT_TRUE(choose_noise({}, hills, {}, {}).level_velocities);
  EXPECT_FALSE(choose_noise(along(VelocityAxes::kImu), hills, {}, {}).level_velocities);
  EXPECT_FALSE(choose_noise({}, drive(0.5, 0.05), {}, {}).level_velocities);
  EXPECT_TRUE(choose_noise(along(VelocityAxes::kLevel), {}, {}, {}).level_velocities);
}

TEST(ModelOf, LevelAxesNeedAVelocityState) {
  VelocitySlamNoise noise;
  noise.level_velocities = true;
  EXPECT_TRUE(model_of({}, noise).level);
  for (const bool input : {false, true}) {
    VelocitySlamSettings found, stated = along(VelocityAxes::kLevel);
    for (VelocitySlamSettings* s : {&found, &stated}) {
      if (input) {
        s->velocity = VelocityRole::kInput;
      } else {
        s->mode = SlamMode::kLocalize;
      }
    }
    EXPECT_FALSE(model_of(found, noise).level);
    EXPECT_NO_THROW(validate(found));
    EXPECT_THROW(validate(stated), UsageError);
  }
}

TEST(ChooseNoise, IsPositiveForAnEmptyRecording) {
  const VelocitySlamNoise noise = choose_noise({}, {}, {}, {});
  EXPECT_GT(noise.motion.sample_sigma.minCoeff(), 0);
  EXPECT_GT(noise.motion.walk.minCoeff(), 0);
  EXPECT_GT(noise.initialisation.u, 0);
}

}  // namespace
}  // namespace chasles
