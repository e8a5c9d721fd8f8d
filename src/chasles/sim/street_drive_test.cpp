#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <chasles/sim/street_drive.hpp>

namespace chasles {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(StreetPath, PositionIsTheIntegralOfTheHeading) {
  const StreetPath path = make_street_path({});
  // Simpson's rule over the whole path: another formula than the one under test, error below 1e-11.
  const int steps = 200'000;
  const double h = path.length / steps;
  const auto direction = [&](double way) {
    const double heading = point_at(path, way).heading;
    return Eigen::Vector2d(std::cos(heading), std::sin(heading));
  };
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  for (int i = 0; i < steps; ++i) {
    p += h / 6 * (direction(i * h) + 4 * direction((i + 0.5) * h) + direction((i + 1) * h));
    if (i % 97 == 0) {
      ASSERT_LT((p - point_at(path, (i + 1) * h).p).norm(), 1e-9) << (i + 1) * h;
    }
  }
  EXPECT_LT((p - point_at(path, path.length).p).norm(), 1e-9);
}

TEST(StreetPath, CurvatureIsTheDerivativeOfTheHeadingAndNeverJumps) {
  const StreetPath path = make_street_path({});
  const double h = 1e-4;
  double before = 0;
  for (double way = h; way < path.length - h; way += 0.05) {
    const double curvature = point_at(path, way).curvature;
    const double slope =
        (point_at(path, way + h).heading - point_at(path, way - h).heading) / (2 * h);
    ASSERT_NEAR(curvature, slope, 1e-7) << way;
    ASSERT_LT(std::abs(curvature - before), 0.002) << way;
    before = curvature;
  }
}

TEST(StreetPath, AFigureOfEightComesBackToItsStart) {
  const StreetPath path = make_street_path({});
  const PathPoint end = point_at(path, path.length);
  EXPECT_LT(end.p.norm(), 1e-9);
  EXPECT_NEAR(end.heading, 0, 1e-12);
  EXPECT_NEAR(path.length, 700, 10);
}

TEST(StreetPath, EachLetterTurnsByAQuarter) {
  const auto heading = [](const char* route) {
    const StreetPath path = make_street_path({.route = route});
    return point_at(path, path.length).heading;
  };
  EXPECT_NEAR(heading(""), 0, 1e-12);
  EXPECT_NEAR(heading("S"), 0, 1e-12);
  EXPECT_NEAR(heading("L"), kPi / 2, 1e-12);
  EXPECT_NEAR(heading("RSR"), -kPi, 1e-12);
  EXPECT_NEAR(heading("LLLLL"), 5 * kPi / 2, 1e-12);
}

TEST(StreetDrive, StartsAtTheIdentityAndAtStandstill) {
  const StreetDrive drive = make_street_drive({});
  const DriveState start = state_at(drive, 0);
  EXPECT_TRUE(start.world_T_imu.R.isIdentity(1e-15));
  EXPECT_TRUE(start.world_T_imu.p.isZero(1e-15));
  EXPECT_TRUE(start.linear_imu.isZero(1e-15));
  EXPECT_TRUE(state_at(drive, drive.duration).linear_imu.isZero(1e-12));
}

TEST(StreetDrive, VelocityIsTheDerivativeOfThePose) {
  const StreetDrive drive = make_street_drive({});
  const double h = 1e-4;
  for (double time = h; time < drive.duration - h; time += 0.037) {
    const DriveState state = state_at(drive, time);
    // X(t-h)^-1 X(t+h) = Exp(2h [omega; v] + O(h^3))
    const SE3 step =
        state_at(drive, time - h).world_T_imu.inverse() * state_at(drive, time + h).world_T_imu;
    const Vector6d twist = se3::log(step) / (2 * h);
    ASSERT_LT((twist.head<3>() - state.angular_imu).norm(), 1e-6) << time;
    ASSERT_LT((twist.tail<3>() - state.linear_imu).norm(), 1e-6) << time;
  }
}

TEST(StreetDrive, IntegratingTheVelocityGivesThePose) {
  const StreetDrive drive = make_street_drive({});
  const int steps = static_cast<int>(drive.duration * 1000);
  const double h = drive.duration / steps;
  SE3 pose;
  for (int i = 0; i < steps; ++i) {
    const DriveState middle = state_at(drive, (i + 0.5) * h);
    Vector6d twist;
    twist << middle.angular_imu, middle.linear_imu;
    pose = pose * se3::exp(h * twist);
    if (i % 1000 == 0) {
      const SE3 truth = state_at(drive, (i + 1) * h).world_T_imu;
      ASSERT_LT((pose.p - truth.p).norm(), 1e-3) << i;
      ASSERT_LT((pose.R - truth.R).norm(), 1e-5) << i;
    }
  }
  EXPECT_LT((pose.p - state_at(drive, drive.duration).world_T_imu.p).norm(), 1e-3);
}

TEST(StreetDrive, AllSixDegreesOfFreedomMove) {
  const StreetDrive drive = make_street_drive({});
  Eigen::Array3d linear = Eigen::Array3d::Zero(), angular = linear;
  for (double time = 0; time < drive.duration; time += 0.05) {
    const DriveState state = state_at(drive, time);
    linear = linear.max(state.linear_imu.array().abs());
    angular = angular.max(state.angular_imu.array().abs());
  }
  EXPECT_GT(linear.minCoeff(), 1e-3);
  EXPECT_GT(angular.minCoeff(), 1e-2);
  EXPECT_NEAR(linear.x(), 8, 0.01);      // cruise_speed
  EXPECT_NEAR(angular.z(), 0.69, 0.02);  // a quarter turn in five seconds, its peak 35/16 the mean
}

TEST(StreetDrive, StopsBeforeEveryThirdTurn) {
  const StreetDrive drive = make_street_drive({});
  double standing = 0;
  for (double time = 0; time < drive.duration; time += 0.01) {
    const DriveState state = state_at(drive, time);
    if (state.linear_imu.isZero(0)) {
      EXPECT_TRUE(state.angular_imu.isZero(0));
      standing += 0.01;
    }
  }
  EXPECT_NEAR(standing, 2 * 3, 0.1);
  EXPECT_LT(make_street_drive({.stop_every = 0}).duration, drive.duration - 2 * 3);
}

TEST(StreetDrive, SpeedAndTurnRateNeverJump) {
  const StreetDrive drive = make_street_drive({});
  const double h = 1e-3;
  for (double time = 0; time + h < drive.duration; time += h) {
    const DriveState a = state_at(drive, time), b = state_at(drive, time + h);
    // 35/16 of the mean acceleration, plus the contribution of the rotating axes.
    ASSERT_LT((b.linear_imu - a.linear_imu).norm(), 6 * h) << time;
    ASSERT_LT((b.angular_imu - a.angular_imu).norm(), 4 * h) << time;
  }
}

}  // namespace
}  // namespace chasles
