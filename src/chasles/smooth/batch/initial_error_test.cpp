#include <cmath>

#include <gtest/gtest.h>

#include <chasles/filter/pixel_projection.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/smooth/batch/exact_settings_testing.hpp>
#include <chasles/smooth/batch/initial_error_detail.hpp>
#include <chasles/smooth/batch/smooth_testing.hpp>
#include <chasles/smooth/batch/velocity_testing.hpp>

namespace chasles {
namespace {

using namespace smooth_detail;
using test::drive_scene;
using test::DriveScene;
using test::small_scene;
using test::SmallScene;

std::vector<SE3> some_way(int steps) {
  std::vector<SE3> poses{{.R = so3::exp({0.1, 0.2, 0.3}), .p = {1, 2, 3}}};
  for (int k = 0; k < steps; ++k) {
    poses.push_back(poses.back() * SE3{.R = so3::exp({0.01, 0, 0.02}), .p = {0.5, 0.1, 0}});
  }
  return poses;
}

TEST(InitialErrorWay, DriftsByItsSizeAndStretches) {
  const std::vector<SE3> way = some_way(50);
  constexpr double kSize = 0.02;
  constexpr int kSeeds = 200;
  double attitude = 0, scale = 0, depth = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    InitialError error(kSize, seed);
    const std::vector<SE3> drifted = error.drifted(way);
    ASSERT_EQ(drifted.size(), way.size());
    EXPECT_EQ(drifted.front().R, way.front().R);
    EXPECT_EQ(drifted.front().p, way.front().p);
    for (std::size_t k = 1; k < way.size(); ++k) {
      const SE3 step = way[k - 1].inverse() * way[k], now = drifted[k - 1].inverse() * drifted[k];
      EXPECT_LT((now.p - error.scale() * step.p).norm(), 1e-12);
      EXPECT_LT(so3::log(step.R.transpose() * now.R).norm(), 6 * kSize / std::sqrt(50.0));
    }
    attitude += so3::log(way.back().R.transpose() * drifted.back().R).squaredNorm();
    scale += std::pow(std::log(error.scale()), 2);
    depth += std::pow(std::log(error.depth_factor() / error.scale()), 2);
  }
  EXPECT_TRUE(test::is_chi2(attitude / (kSize * kSize), 3 * kSeeds));
  EXPECT_TRUE(test::is_chi2(scale / (kSize * kSize), kSeeds));
  EXPECT_TRUE(test::is_chi2(depth / (kSize * kSize), kSeeds));
}

TEST(InitialErrorWay, TheSameSeedTheSameErrors) {
  const std::vector<SE3> way = some_way(5);
  const auto last = [&](std::uint64_t seed) { return InitialError(0.1, seed).drifted(way).back(); };
  EXPECT_EQ(last(3).p, last(3).p);
  EXPECT_NE(last(3).p, last(4).p);
}

BatchGraph graph_of(const InertialBatchInput& input, BatchSettings settings, double error) {
  BatchReport report;
  settings.initial_error = error;
  return batch_graph(input, settings, report);
}

// Anchored and Cartesian landmarks are moved to the same positions, visible from their first view.
TEST(InitialErrorGraph, TakesLandmarksAlongInBothForms) {
  SmallScene scene = small_scene({.cameras = 2});
  scene.input.initial = scene.truth;
  const BatchGraph anchored = graph_of(scene.input,
                                       test::exact_settings(LandmarkForm::kInverseDepth), 0.2),
                   cartesian =
                       graph_of(scene.input, test::exact_settings(LandmarkForm::kCartesian), 0.2),
                   before =
                       graph_of(scene.input, test::exact_settings(LandmarkForm::kInverseDepth), 0);
  ASSERT_EQ(anchored.points.size(), cartesian.points.size());
  ASSERT_EQ(anchored.points.size(), before.points.size());
  double moved = 0;
  for (std::size_t i = 0; i < anchored.points.size(); ++i) {
    const BatchPoint& point = anchored.points[i];
    const Landmark landmark = landmark_of(scene.input, anchored, point);
    const HomogeneousPoint at = homogeneous(anchor_of(anchored, point), landmark);
    EXPECT_LT((at.p_world / at.w - cartesian.points[i].parameters).norm(), 1e-9);
    EXPECT_EQ(point.parameters.head<2>(), before.points[i].parameters.head<2>());
    moved += std::abs(std::log(point.parameters.z() / before.points[i].parameters.z()));
  }
  EXPECT_GT(moved / static_cast<double>(anchored.points.size()), 0.05);
}

TEST(InitialErrorGraph, TurnsVelocitiesWithTheWay) {
  SmallScene scene = small_scene();
  scene.input.initial = scene.truth;
  const BatchGraph before = graph_of(scene.input, {}, 0), after = graph_of(scene.input, {}, 0.2);
  const auto in_body = [](const BatchKeyframe& k) {
    return Eigen::Vector3d(k.state.world_T_imu.R.transpose() * k.state.v_world);
  };
  const double scale = in_body(after.keyframes[0]).norm() / in_body(before.keyframes[0]).norm();
  EXPECT_GT(std::abs(std::log(scale)), 1e-3);
  for (std::size_t k = 0; k < before.keyframes.size(); ++k) {
    EXPECT_LT((in_body(after.keyframes[k]) - scale * in_body(before.keyframes[k])).norm(), 1e-12);
    EXPECT_EQ(after.keyframes[k].state.biases(), before.keyframes[k].state.biases());
  }
}

// From these errors every chart finds the same minimum as from the filter's run.
class InitialErrorSearch : public test::OverCharts {
 protected:
  BatchSettings settings(double error, LandmarkForm landmarks) const {
    BatchSettings s = test::exact_settings(landmarks);
    s.chart = chart().name;
    s.initial_error = error;
    return s;
  }
};

TEST_P(InitialErrorSearch, EndsInTheSameMinimum) {
  SmallScene scene = small_scene({.frames = 12, .cameras = 2});
  scene.input.initial = scene.truth;
  for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    const InertialBatchResult near =
                                  smooth(scene.input, "standard", test::exact_settings(landmarks)),
                              far = smooth(scene.input, "standard", settings(0.1, landmarks));
    EXPECT_GT(far.report.initial_cost, 10 * near.report.initial_cost);
    EXPECT_NEAR(far.report.final_cost / near.report.final_cost, 1, 1e-9);
    EXPECT_LT(far.report.decrease_left, 1e-9);
    EXPECT_FALSE(far.report.stalled);
    for (std::size_t k = 0; k < near.estimates.size(); ++k) {
      const Estimate &a = near.estimates[k], &b = far.estimates[k];
      EXPECT_LT((a.world_T_imu.p - b.world_T_imu.p).norm(), 1e-5);
      EXPECT_LT(test::covariance_difference(b.covariance, a.covariance), 1e-3);
    }
  }
}

TEST_P(InitialErrorSearch, WithBodyVelocitiesTheSame) {
  const DriveScene s = drive_scene({.frames = 12});
  for (const LandmarkForm landmarks : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    const VelocityBatchResult near = smooth(s.input, test::exact_settings(landmarks)),
                              far = smooth(s.input, settings(0.1, landmarks));
    EXPECT_GT(far.report.initial_cost, 10 * near.report.initial_cost);
    EXPECT_NEAR(far.report.final_cost / near.report.final_cost, 1, 1e-9);
    EXPECT_FALSE(far.report.stalled);
    for (std::size_t k = 0; k < near.estimates.size(); ++k) {
      const Estimate &a = near.estimates[k], &b = far.estimates[k];
      EXPECT_LT((a.world_T_imu.p - b.world_T_imu.p).norm(), 1e-5);
      EXPECT_LT(test::covariance_difference(b.pose_covariance(), a.pose_covariance()), 1e-3);
    }
  }
}

// With a tolerance of the whole cost, a search ends after its first steps and counts as converged.
TEST_P(InitialErrorSearch, WhatEndsOnTheWayHasStalledAndSaysHowMuchIsLeft) {
  const SmallScene scene = [] {
    SmallScene s = small_scene({.frames = 12, .cameras = 2});
    s.input.initial = s.truth;
    return s;
  }();
  BatchSettings ending = settings(3e-3, LandmarkForm::kInverseDepth);
  const double least = smooth(scene.input, "standard", ending).report.final_cost;
  ending.tolerance = 1;
  const BatchReport report = smooth(scene.input, "standard", ending).report;
  EXPECT_TRUE(report.converged);
  EXPECT_TRUE(report.stalled);
  EXPECT_GT(report.decrease_left, 1e-3);
  EXPECT_NEAR(report.decrease_left / (1 - least / report.final_cost), 1, 0.05);
}

INSTANTIATE_TEST_SUITE_P(Charts, InitialErrorSearch, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

}  // namespace
}  // namespace chasles
