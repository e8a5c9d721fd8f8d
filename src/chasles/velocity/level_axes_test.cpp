#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/lie/so3.hpp>
#include <chasles/velocity/level_axes.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Rz(yaw) Ry(pitch) Rx(roll), nose up for a positive pitch.
Matrix3d attitude(double yaw, double pitch, double roll) {
  return so3::exp(yaw * Vector3d::UnitZ()) * so3::exp(-pitch * Vector3d::UnitY()) *
         so3::exp(roll * Vector3d::UnitX());
}

Vector3d up_of(const Matrix3d& nav_R_imu) { return nav_R_imu.transpose() * Vector3d::UnitZ(); }

TEST(LevelAxes, AreTheBodysWithoutRollAndPitch) {
  for (const double yaw : {-2.0, 0.0, 1.1}) {
    for (const double pitch : {-1.2, -0.02, 0.0, 0.4}) {
      for (const double roll : {-2.5, 0.0, 0.03, 1.0}) {
        const Matrix3d nav_R_imu = attitude(yaw, pitch, roll);
        const auto axes = level_axes(up_of(nav_R_imu));
        ASSERT_TRUE(axes);
        const Matrix3d nav_R_level = nav_R_imu * axes->level_R_imu.transpose();
        EXPECT_LT((nav_R_level - attitude(yaw, 0, 0)).norm(), 1e-14);
      }
    }
  }
}

TEST(LevelAxes, TurnWithTheVerticalAsTheirDerivativeSays) {
  constexpr double kStep = 1e-6;
  for (const double pitch : {-0.9, 0.0, 0.3}) {
    for (const double roll : {-1.0, 0.0, 0.2}) {
      const Vector3d up = up_of(attitude(0.7, pitch, roll));
      const LevelAxes axes = *level_axes(up);
      for (const Vector3d& axis : {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1)}) {
        const Vector3d plus = so3::exp(kStep * axis) * up, minus = so3::exp(-kStep * axis) * up;
        const Vector3d turn =
            so3::log(level_axes(plus)->level_R_imu * level_axes(minus)->level_R_imu.transpose());
        EXPECT_LT((turn - axes.by_vertical * (plus - minus)).norm(), 1e-8 * kStep);
      }
    }
  }
}

TEST(LevelAxes, HaveNoHeadingWhereTheBodyLooksUp) {
  EXPECT_FALSE(level_axes({1, 0, 0}));
  EXPECT_FALSE(level_axes({-std::cos(0.04), std::sin(0.04), 0}));
  EXPECT_TRUE(level_axes({std::cos(0.06), std::sin(0.06), 0}));
  EXPECT_FALSE(level_axes(Vector3d::Constant(std::numeric_limits<double>::quiet_NaN())));
}

struct Hills {
  bool level = true;
  double speed = 10;       // [m/s]
  double height = 0.03;    // of the road's slope [rad]
  double springs = 0.003;  // pitch of the body on the road [rad]
  double rate_sigma = 0.001, velocity_sigma = 0.02, rate_bias = 0;
  int samples = 600;
};

// A car on hills with a period of 8 s; its suspension pitches with a period of 1.3 s.
std::vector<BodyVelocity> drive(const Hills& hills) {
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) {
    return Vector3d(sigma * normal(generator), sigma * normal(generator),
                    sigma * normal(generator));
  };
  std::vector<BodyVelocity> velocities;
  for (int k = 0; k < hills.samples; ++k) {
    const double t = 0.1 * k, w = 2 * std::numbers::pi / 8, f = 2 * std::numbers::pi / 1.3;
    const double slope = hills.height * std::sin(w * t);
    const double climb = hills.level ? slope : -hills.springs * std::sin(f * t);
    const double pitch_rate =
        hills.height * w * std::cos(w * t) + hills.springs * f * std::cos(f * t);
    velocities.push_back(
        {.time = from_seconds(100 + t),
         .linear_imu = hills.speed * Vector3d(std::cos(climb), 0, std::sin(climb)) +
                       noise(hills.velocity_sigma),
         .angular_imu = Vector3d(0, hills.rate_bias - pitch_rate, 0.2) + noise(hills.rate_sigma)});
  }
  return velocities;
}

TEST(LevelEvidence, LevelVelocitiesClimbAsTheBodyPitches) {
  const auto evidence = level_evidence(drive({}));
  ASSERT_TRUE(evidence);
  EXPECT_TRUE(evidence->level());
  EXPECT_GT(evidence->slope, 0.5);
  EXPECT_LT(evidence->slope, 1);  // the suspension pitches it without climbing
  EXPECT_NEAR(level_evidence(drive({.springs = 0}))->slope, 1, 0.05);
}

TEST(LevelEvidence, VelocitiesAlongTheBodysAxesDoNotClimb) {
  const auto evidence = level_evidence(drive({.level = false}));
  ASSERT_TRUE(evidence);
  EXPECT_FALSE(evidence->level());
  EXPECT_LT(evidence->slope, 0.05);
}

TEST(LevelEvidence, IsTheSameOfADriveBackwards) {
  for (const bool level : {true, false}) {
    std::vector<BodyVelocity> velocities = drive({.level = level, .springs = 0.01});
    const LevelEvidence forwards = *level_evidence(velocities);
    for (BodyVelocity& u : velocities) u.linear_imu = -u.linear_imu;
    EXPECT_EQ(level_evidence(velocities)->slope, forwards.slope);
    EXPECT_EQ(forwards.level(), level);
  }
}

TEST(LevelEvidence, ABiasOfTheRatesIsNoPitch) {
  const double unbiased = level_evidence(drive({}))->slope;
  EXPECT_NEAR(level_evidence(drive({.rate_bias = 0.03}))->slope, unbiased, 1e-3);
}

TEST(LevelEvidence, SaysNothingWhereNothingCanBeSaid) {
  const auto noisy = level_evidence(drive({.rate_sigma = 0.05, .velocity_sigma = 0.5}));
  ASSERT_TRUE(noisy);
  EXPECT_FALSE(noisy->level());
  EXPECT_FALSE(level_evidence({}));
  EXPECT_FALSE(level_evidence(drive({.speed = 1})));
  EXPECT_FALSE(level_evidence(drive({.samples = 20})));
  std::vector<BodyVelocity> flat(100);
  for (int k = 0; k < 100; ++k) {
    flat[static_cast<std::size_t>(k)] = {.time = from_seconds(0.1 * k), .linear_imu = {9, 0, 0}};
  }
  EXPECT_FALSE(level_evidence(flat));
  auto broken = drive({});
  broken[300].angular_imu.y() = std::numeric_limits<double>::quiet_NaN();
  const auto of_broken = level_evidence(broken);
  EXPECT_FALSE(of_broken && of_broken->level());
}

TEST(LevelEvidence, GapsAndTimesThatDoNotRiseAreNoPairs) {
  auto gap = drive({});
  gap.erase(gap.begin() + 200, gap.begin() + 300);
  // Without the pairs that span it, the remaining ones give the same result.
  EXPECT_NEAR(level_evidence(gap)->slope, level_evidence(drive({}))->slope, 0.05);
  auto still = drive({});
  for (BodyVelocity& u : still) u.time = still.front().time;
  EXPECT_FALSE(level_evidence(still));
}

}  // namespace
}  // namespace chasles
