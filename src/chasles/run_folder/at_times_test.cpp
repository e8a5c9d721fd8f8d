#include <cmath>

#include <gtest/gtest.h>

#include <chasles/lie/so3.hpp>
#include <chasles/run_folder/at_times.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;
using std::chrono::milliseconds;

// States every 100 ms that move at 1 m/s along x and turn at 1 rad/s about z.
Run steady_run(std::size_t count) {
  Run run;
  run.extra_names = {"speed"};
  for (std::size_t i = 0; i < count; ++i) {
    const double t = 0.1 * static_cast<double>(i);
    RunState& s = run.states.emplace_back();
    s.time = milliseconds(100 * i);
    s.world_T_imu = {so3::exp({0, 0, t}), {t, 0, 0}};
    s.pose_covariance = (1 + t) * Matrix6d::Identity();
    s.extra = {10 + t};
    s.extra_sigma = {1 + static_cast<double>(i)};
    s.nis = 3;
    s.observations = 7;
    s.health = "ok";
    run.smoothed.push_back({s.time, s.world_T_imu, 0.5 * s.pose_covariance});
  }
  return run;
}

TEST(AtTimes, AtTheTimeOfAStateItIsThatState) {
  const auto run = steady_run(4);
  const std::vector<Time> times{milliseconds(300), milliseconds(0), milliseconds(100)};
  const auto rows = states_at(run, times);
  ASSERT_EQ(rows.size(), 3);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const RunState& state = run.states[static_cast<std::size_t>(times[i] / milliseconds(100))];
    EXPECT_TRUE(rows[i].known);
    EXPECT_EQ(rows[i].row.world_T_imu.R, state.world_T_imu.R) << "to the last bit";
    EXPECT_EQ(rows[i].row.extra, state.extra);
    EXPECT_EQ(rows[i].row.nis, 3);
  }
}

TEST(AtTimes, BetweenStatesTheMotionIsSteady) {
  const auto run = steady_run(4);
  const std::vector<Time> times{milliseconds(125)};
  const auto at = states_at(run, times)[0];
  ASSERT_TRUE(at.known);
  EXPECT_LT((at.row.world_T_imu.R - so3::exp({0, 0, 0.125})).norm(), 1e-12);
  EXPECT_LT((at.row.world_T_imu.p - Vector3d(0.125, 0, 0)).norm(), 1e-12);
  EXPECT_NEAR(at.row.pose_covariance(4, 4), 1.125, 1e-12);
  EXPECT_NEAR(at.row.extra[0], 10.125, 1e-12);
  EXPECT_NEAR(at.row.extra_sigma[0], std::sqrt(0.75 * 4 + 0.25 * 9), 1e-12);
  EXPECT_EQ(at.row.nis, 0);
  EXPECT_EQ(at.row.observations, 0);
  EXPECT_EQ(at.row.health, "ok");
  const auto smoothed = smoothed_at(run, times)[0];
  EXPECT_TRUE(smoothed.known);
  EXPECT_NEAR(smoothed.row.pose_covariance(0, 0), 0.5 * 1.125, 1e-12);
}

// The mean of two errors with any correlation has at most the mean of their covariances.
TEST(AtTimes, TheCovarianceIsAnUpperBound) {
  const auto run = steady_run(2);
  const std::vector<Time> times{milliseconds(30)};
  const double stated = states_at(run, times)[0].row.pose_covariance(5, 5);
  const double a = run.states[0].pose_covariance(5, 5), b = run.states[1].pose_covariance(5, 5);
  for (const double correlation : {-1.0, -0.3, 0.0, 0.5, 1.0}) {
    const double true_variance = 0.49 * a + 0.09 * b + 2 * 0.21 * correlation * std::sqrt(a * b);
    EXPECT_LE(true_variance, stated * (1 + 1e-12)) << correlation;
  }
}

TEST(AtTimes, WhatIsNotKnownIsTheNearestState) {
  auto run = steady_run(9);
  run.states.erase(run.states.begin() + 2, run.states.begin() + 4);  // 200 and 300 ms
  run.states[4].health = "lost";                                     // 600 ms
  const std::vector<Time> times{milliseconds(-5),  milliseconds(150), milliseconds(220),
                                milliseconds(280), milliseconds(550), milliseconds(600),
                                milliseconds(650), milliseconds(750), milliseconds(801)};
  std::vector<bool> known;
  for (const auto& at : states_at(run, times)) {
    known.push_back(at.known);
    EXPECT_TRUE(at.row.world_T_imu.p.allFinite());
  }
  EXPECT_EQ(known, (std::vector{false, false, false, false, false, false, false, true, false}));
  EXPECT_TRUE(states_at(run, times, milliseconds(300))[1].known);
  const auto rows = states_at(run, times);
  EXPECT_EQ(rows[0].row.world_T_imu.p.x(), 0);
  EXPECT_EQ(rows[0].row.time, milliseconds(-5));
  EXPECT_EQ(rows[2].row.world_T_imu.p, Vector3d(0.1, 0, 0)) << "nearer than that at 400 ms";
  EXPECT_EQ(rows[3].row.world_T_imu.p, Vector3d(0.4, 0, 0));
  // The smoothed path has poses where the run was lost.
  EXPECT_FALSE(smoothed_at(run, times)[5].known);
  EXPECT_TRUE(smoothed_at(run, times)[2].known);
  EXPECT_TRUE(states_at(chasles::Run{}, times).empty());
}

}  // namespace
}  // namespace chasles
