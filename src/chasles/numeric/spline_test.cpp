#include <cmath>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/numeric/spline.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;

constexpr Time kStart{1'700'000'000'123'456'789};

// A motion that rotates about all axes, through more than a full turn.
SE3 tumbling(double t) {
  return {so3::exp({0, 0, 1.1 * t}) * so3::exp({0.8 * std::sin(1.7 * t), 0.5 * std::cos(t), 0}),
          {std::sin(1.3 * t), 2 * std::cos(0.7 * t), 0.3 * t + 0.2 * std::sin(2 * t)}};
}

template <typename Pose>
Trajectory sampled(const Pose& pose, double duration, double rate) {
  Trajectory poses;
  for (int i = 0; i <= std::lround(duration * rate); ++i) {
    const Time since = from_seconds(i / rate);
    poses.push_back({kStart + since, pose(to_seconds(since))});
  }
  return poses;
}

struct Errors {
  double position = 0, attitude = 0;
};

Errors largest_errors(const Spline& spline, double until) {
  Errors worst;
  for (double t = 1; t < until - 1; t += 0.0137) {
    const SE3 fitted = motion_at(spline, t).world_T_imu;
    const SE3 expected = tumbling(t);
    worst.position = std::max(worst.position, (fitted.p - expected.p).norm());
    worst.attitude = std::max(worst.attitude, so3::log(fitted.R.transpose() * expected.R).norm());
  }
  return worst;
}

TEST(Spline, EveryDerivativeIsTheDerivative) {
  const Spline spline = fit_spline(sampled(tumbling, 10, 50), 0.2);
  const auto at = [&](double t, const auto& of) {
    return test::numeric_derivative(
        [&](const Eigen::Matrix<double, 1, 1>& s) { return Eigen::VectorXd(of(t + s[0])); },
        Eigen::Matrix<double, 1, 1>::Zero());
  };
  for (double t = 0.07; t < 10; t += 0.2) {
    const Motion now = motion_at(spline, t);
    const auto p = [&](double s) { return motion_at(spline, s).world_T_imu.p; };
    const auto v = [&](double s) { return motion_at(spline, s).v_world; };
    const auto turn = [&](double s) {
      return so3::log(now.world_T_imu.R.transpose() * motion_at(spline, s).world_T_imu.R);
    };
    EXPECT_TRUE(test::agree(now.v_world, at(t, p), 1e-9)) << t;
    EXPECT_TRUE(test::agree(now.a_world, at(t, v), 1e-9)) << t;
    EXPECT_TRUE(test::agree(now.omega_imu, at(t, turn), 1e-9)) << t;
  }
}

TEST(Spline, AccelerationAndAngularAccelerationAreContinuous) {
  const Spline spline = fit_spline(sampled(tumbling, 10, 50), 0.2);
  const double h = 1e-6;
  for (int knot = 1; knot < 50; ++knot) {
    const double t = 0.2 * knot;
    const Motion before = motion_at(spline, t - h), at = motion_at(spline, t);
    const Motion after = motion_at(spline, t + h);
    EXPECT_TRUE(test::agree(before.a_world, after.a_world, 1e-4)) << t;
    const Vector3d into = (at.omega_imu - before.omega_imu) / h;
    const Vector3d out = (after.omega_imu - at.omega_imu) / h;
    EXPECT_TRUE(test::agree(into, out, 1e-4)) << t;
  }
}

TEST(Spline, CubicsAndSteadyTurnsAreReproduced) {
  const Vector3d a(1, -2, 0.5), b(0.3, 0.1, -0.2), c(0.02, -0.01, 0.03), axis(0.3, -0.5, 0.9);
  const auto pose = [&](double t) -> SE3 {
    return {so3::exp({0.4, 1, -0.2}) * so3::exp(t * axis), t * a + t * t * b + t * t * t * c};
  };
  // The last segment is longer than the poses.
  const Spline spline = fit_spline(sampled(pose, 7.13, 100), 0.25);
  EXPECT_DOUBLE_EQ(spline.duration, 7.13);
  for (double t = 0; t <= 7.13; t += 0.01) {
    const Motion now = motion_at(spline, t);
    ASSERT_TRUE(test::agree(now.world_T_imu.p, pose(t).p, 1e-9)) << t;
    ASSERT_TRUE(test::agree(now.world_T_imu.R, pose(t).R, 1e-9)) << t;
    ASSERT_TRUE(test::agree(now.a_world, Vector3d(2 * b + 6 * t * c), 1e-7)) << t;
    ASSERT_TRUE(test::agree(now.omega_imu, axis, 1e-8)) << t;
  }
}

TEST(Spline, TheErrorFallsWithAPowerOfTheKnotInterval) {
  const Trajectory poses = sampled(tumbling, 10, 200);
  const Errors coarse = largest_errors(fit_spline(poses, 0.2), 10);
  const Errors fine = largest_errors(fit_spline(poses, 0.1), 10);
  EXPECT_LT(coarse.position, 2e-4);
  EXPECT_LT(coarse.attitude, 2e-3);
  // The fourth in a vector space; the third where successive steps do not commute.
  EXPECT_NEAR(coarse.position / fine.position, 16, 3);
  EXPECT_NEAR(coarse.attitude / fine.attitude, 8, 2);
}

TEST(Spline, NoiseIsAveraged) {
  test::Random random(4);
  Trajectory poses = sampled(tumbling, 20, 200);
  for (StampedPose& stamped : poses) {
    stamped.pose.p += 0.01 * random.normal_vector(3);
    stamped.pose.R *= so3::exp(0.01 * random.normal_vector(3));
  }
  const Spline spline = fit_spline(poses, 0.1);
  double position = 0, attitude = 0;
  int count = 0;
  for (double t = 1; t < 19; t += 0.003, ++count) {
    const SE3 fitted = motion_at(spline, t).world_T_imu, truth = tumbling(t);
    position += (fitted.p - truth.p).squaredNorm();
    attitude += so3::log(fitted.R.transpose() * truth.R).squaredNorm();
  }
  // Least squares keeps 1/20 of the variance: one control for 20 poses.
  EXPECT_NEAR(position / count, 3e-4 / 20, 3e-4 / 20 * 0.25);
  EXPECT_NEAR(attitude / count, 3e-4 / 20, 3e-4 / 20 * 0.25);
}

TEST(Spline, AGapIsBridgedEvenly) {
  const auto pose = [](double t) -> SE3 { return {so3::exp({0, 0, 0.2 * t}), {t, 2 * t, 0}}; };
  Trajectory poses = sampled(pose, 20, 50);
  poses.erase(poses.begin() + 300, poses.begin() + 700);
  const Spline spline = fit_spline(poses, 0.1);
  for (double t = 0; t < 20; t += 0.1) {
    ASSERT_TRUE(test::agree(motion_at(spline, t).world_T_imu.p, pose(t).p, 1e-6)) << t;
    ASSERT_TRUE(test::agree(motion_at(spline, t).world_T_imu.R, pose(t).R, 1e-6)) << t;
  }
}

TEST(Spline, WhatIsNoMotionIsRejected) {
  const Trajectory poses = sampled(tumbling, 1, 50);
  const auto rejected = [](const Trajectory& path, double knot_interval) {
    try {
      fit_spline(path, knot_interval);
    } catch (const UsageError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(rejected({}, 0.1).find("0 poses"), std::string::npos);
  EXPECT_NE(rejected({poses[0]}, 0.1).find("1 poses"), std::string::npos);
  EXPECT_NE(rejected({poses[0], poses[2], poses[1]}, 0.01).find("pose 2"), std::string::npos);
  EXPECT_NE(rejected({poses[0], poses[0]}, 0.1).find("pose 1"), std::string::npos);
  EXPECT_NE(rejected(poses, 2).find("at least one knot interval"), std::string::npos);
  EXPECT_NE(rejected({poses[0], {poses[0].time + std::chrono::hours(1000), {}}}, 0.1).find("gap"),
            std::string::npos);
}

}  // namespace
}  // namespace chasles
