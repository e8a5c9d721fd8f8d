#include <chasles/recording/gravity.hpp>
#include <chasles/recording/inertial_testing.hpp>

namespace chasles {
namespace {

using test::swung;

const Eigen::Vector3d kTilted(-3, -9.2, 1.4);

TEST(Gravity, IsFoundInAWorldThatIsNotLevelBesideTheBias) {
  const Recording r = swung(kTilted, 30);
  const auto fit = fit_gravity(r.truth, r.imu);
  ASSERT_TRUE(fit);
  // The remaining error is the interpolation of R between poses 50 ms apart.
  EXPECT_LT((fit->gravity_world - kTilted).norm(), 5e-3);
  EXPECT_LT((fit->accelerometer_bias - test::kBias).norm(), 5e-3);
  EXPECT_EQ(fit->windows, 28) << "of 30 poses a second apart";
}

// Positions in another unit leave more: the right scale is the lowest point of a parabola.
TEST(Gravity, WhatIsLeftShowsTheScaleOfThePositions) {
  const Recording r = swung(kTilted, 30);
  const auto left = [&](double scale) {
    Trajectory scaled = r.truth;
    for (StampedPose& row : scaled) row.pose.p *= scale;
    const double rms = fit_gravity(scaled, r.imu)->left;
    return rms * rms;
  };
  EXPECT_LT(left(1), 1e-4 * left(0));
  const double slope = (left(3) - left(-3)) / 6, bend = (left(3) + left(-3)) / 2 - left(0);
  EXPECT_NEAR(-slope / (2 * bend / 9), 1, 1e-3);
  EXPECT_NEAR(left(1), left(0) + slope + bend / 9, 1e-6 * left(0));
}

TEST(Gravity, NoiseOfThePosesHardlyMatters) {
  Recording r = swung(kTilted, 60);
  test::Random random(5);
  for (StampedPose& row : r.truth) {
    row.pose.p += 2e-3 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
  }
  const auto fit = fit_gravity(r.truth, r.imu);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->gravity_world - kTilted).norm(), 0.02);
}

TEST(Gravity, WindowsWithAGapAreLeftOut) {
  Recording r = swung(kTilted, 30);
  const auto all = fit_gravity(r.truth, r.imu);
  // Samples that would bias the fit if they were used across the gap.
  for (std::size_t k = 2000; k < 2100; ++k) r.imu[k].specific_force_imu.setConstant(100);
  r.imu.erase(r.imu.begin() + 1990, r.imu.begin() + 2110);
  r.truth.erase(r.truth.begin() + 400, r.truth.begin() + 430);
  const auto fit = fit_gravity(r.truth, r.imu);
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->windows, all->windows - 3);
  EXPECT_LT((fit->gravity_world - kTilted).norm(), 5e-3);
}

TEST(Gravity, ABiasThatNothingShowsStaysNearZero) {
  Recording r;
  for (int k = 0; k <= 2000; ++k) {
    const Time time = from_seconds(0.005 * k);
    r.imu.push_back({.time = time, .specific_force_imu = {0, 0, 10}});
    r.truth.push_back({.time = time, .pose = {}});
  }
  const auto fit = fit_gravity(r.truth, r.imu);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->gravity_world - Eigen::Vector3d(0, 0, -10)).norm(), 1e-2);
  EXPECT_LT(fit->accelerometer_bias.norm(), 1e-2);
}

TEST(Gravity, TooLittleShowsNothing) {
  const Recording r = swung(kTilted, 4);
  EXPECT_FALSE(fit_gravity(r.truth, r.imu));
  EXPECT_FALSE(fit_gravity({}, r.imu));
  EXPECT_FALSE(fit_gravity(r.truth, {}));
}

TEST(Gravity, SamplesThatEndEarlyOrBeginLateAreNoMatter) {
  Recording r = swung(kTilted, 30);
  r.imu.resize(4000);
  r.imu.erase(r.imu.begin(), r.imu.begin() + 500);
  const auto fit = fit_gravity(r.truth, r.imu);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->gravity_world - kTilted).norm(), 1e-2);
}

}  // namespace
}  // namespace chasles
