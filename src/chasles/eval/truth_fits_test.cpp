#include <cmath>

#include <gtest/gtest.h>

#include <chasles/eval/attitude_fit.hpp>
#include <chasles/eval/position_fit.hpp>
#include <chasles/eval/truth_interpolation.hpp>
#include <chasles/eval/truth_walk_testing.hpp>

// The fits that the examination of a truth uses.
namespace chasles {
namespace {

using test::changed;
using test::sampled;

// By the closed form: a parabola of acceleration a is off by a h^2 / sqrt(120) on the chords.
TEST(TruthInterpolation, IsThatOfTheChords) {
  const auto parabola = [](double t) { return SE3{so3::exp({0, 0, 0.15 * t * t}), {t * t, 0, 0}}; };
  const InterpolationError error = interpolation_error(
      sampled(200, 0, 10, parabola), sampled(2.5, 0, 10, parabola), std::chrono::seconds(1));
  EXPECT_NEAR(error.position, 2 * 0.16 / std::sqrt(120.0), 1e-4);
  EXPECT_NEAR(error.attitude, 0.3 * 0.16 / std::sqrt(120.0), 1e-5);
  EXPECT_GT(error.share, 0.9);
}

TEST(AttitudeFit, FindsWorldAndBody) {
  const SE3 world{so3::exp({0.2, -0.4, 1.1}), {}}, body{so3::exp({0.9, 0.3, -0.5}), {}};
  const auto other = changed([&](StampedPose& row) { row.pose = world * row.pose * body; });
  const auto fit = fit_attitudes(sampled(20, 1, 20), other, {.body = true});
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->rms, 0.02);
  const auto known =
      fit_attitudes(sampled(20, 1, 20), other, {.truth_R_estimate = world.R, .body = true});
  ASSERT_TRUE(known);
  EXPECT_LT((known->body - body.R).norm(), 1e-4);
  EXPECT_LT(known->rms, 1e-4);
}

// The closed form: a path that is off by a known rigid motion, scale, time and point.
TEST(PositionFit, FindsTimeScaleAndPoint) {
  const Trajectory reference = sampled(20, 1, 20);
  const SE3 world{so3::exp({0.2, -0.4, 1.1}), {5, -3, 2}};
  const Eigen::Vector3d point(0.2, -0.1, 0.15);
  const Trajectory other = changed([&](StampedPose& row) {
    row.pose.p = world.R * (3 * (row.pose * point)) + world.p;
    row.time -= std::chrono::milliseconds(40);
  });
  const auto fit = fit_positions(reference, other, {.scale = true, .offset = true, .point = true});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->scale, 3, 1e-4);
  EXPECT_NEAR(fit->offset, 0.04, 1e-4);
  EXPECT_LT((fit->point - point).norm(), 1e-3);
  EXPECT_LT((fit->truth_T_estimate.R - world.R).norm(), 1e-3);
  EXPECT_LT(fit->rms, 1e-3);
}

}  // namespace
}  // namespace chasles
