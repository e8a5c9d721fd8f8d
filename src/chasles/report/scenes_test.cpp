#include <cmath>

#include <gtest/gtest.h>

#include <chasles/report/report.hpp>
#include <chasles/report/testing.hpp>

namespace chasles {
namespace {

using test::column;
using test::data_of;
using test::synthetic_drive;

ReportRun drive_of_scene() { return synthetic_drive({.states = 50, .landmarks = 40}); }

/// Adds an IMU bias to the extra names, which makes the world level.
void make_level(ReportRun& drive) {
  drive.run.extra_names = {"accelerometer_bias_x"};
  for (RunState& state : drive.run.states) {
    state.extra = {0.01};
    state.extra_sigma = {0.02};
  }
}

TEST(Scenes, RunsOfOneRecordingArePlacedOnTheTruthByPositionAndYaw) {
  ReportRun one = drive_of_scene(), other = drive_of_scene();
  one.label = "one";
  one.summary = other.summary = R"({"chart": "standard"})";
  make_level(one);
  make_level(other);
  // In another world, rotated about the vertical, and 0.2 m too high in every second state. The fit
  // removes all but 0.1 m, up and down.
  const SE3 elsewhere{so3::exp({0, 0, 1.1}), {30, -7, 2}};
  for (std::size_t i = 0; i < one.run.states.size(); ++i) {
    SE3 pose = one.run.truth[i].pose;
    other.run.states[i].world_T_imu = elsewhere * pose;
    pose.p.z() += i % 2 == 0 ? 0.2 : 0.0;
    one.run.states[i].world_T_imu = elsewhere * pose;
  }
  one.run.plan = {{.kind = PlanLine::Kind::kWall, .points = {{1, 2}, {3, 4}}},
                  {.kind = PlanLine::Kind::kFurniture, .points = {{5, 6}, {7, 8}, {9, 9}}},
                  {.kind = PlanLine::Kind::kWall, .points = {{0, 0}, {-1, 0}}}};
  const nlohmann::json data = data_of(run_page({other, one}));
  EXPECT_EQ(data["runs"][1]["label"], "one");
  ASSERT_EQ(data["scenes"].size(), 1U);
  const nlohmann::json scene = data["scenes"][0], runs = scene["runs"];
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs[1]["run"], 1);
  const auto x = column(runs[0]["x"]), truth = column(scene["truth"]["x"]);
  const auto exact = column(runs[0]["ez"]), off = column(runs[1]["ez"]);
  const auto t = column(runs[1]["t"]);
  ASSERT_EQ(x.size(), 50U);
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_NEAR(x[i], truth[i], 1e-4);
    EXPECT_NEAR(truth[i] + scene["origin"][0].get<double>(), one.run.truth[i].pose.p.x(), 1e-4);
    EXPECT_NEAR(exact[i], 0, 1e-6);
    EXPECT_NEAR(off[i], i % 2 == 0 ? 0.1 : -0.1, 1e-5);
    EXPECT_NEAR(t[i], to_seconds(one.run.truth[i].time - one.run.truth[0].time), 1e-9);
  }
  const auto wall = column(scene["plan"]["wall"]["y"]);
  ASSERT_EQ(wall.size(), 6U) << "a NaN after each line";
  EXPECT_NEAR(wall[1] + scene["origin"][1].get<double>(), 4, 1e-5);
  EXPECT_TRUE(std::isnan(wall[2]));
  EXPECT_EQ(column(scene["plan"]["furniture"]["x"]).size(), 4U);
}

TEST(Scenes, WithAnImuAnErrorOfTheFirstTiltIsNoErrorOfLaterOnes) {
  ReportRun drive = drive_of_scene();
  const double tilt = 0.01;
  for (std::size_t i = 0; i < drive.run.states.size(); ++i) {
    RunState& state = drive.run.states[i];
    state.world_T_imu = drive.run.truth[i].pose;
    state.pose_covariance.setIdentity();
    state.pose_covariance.topLeftCorner<3, 3>() *= tilt * tilt;
  }
  SE3& first = drive.run.states[0].world_T_imu;
  first.R = so3::exp({tilt, 0, 0}) * first.R;
  const auto mean_nees = [&] {
    return data_of(run_page({drive, drive}))["scenes"][0]["runs"][1]["mean_nees"]["attitude"]
        .get<double>();
  };
  EXPECT_NEAR(mean_nees(), 49.0 / 50, 1e-6)
      << "without gravity, the world is that of the first pose";
  make_level(drive);
  EXPECT_NEAR(mean_nees(), 1.0 / 50, 1e-6);
}

TEST(Scenes, OnlyRunsOfOneTruthOrWithAPlanMakeAScene) {
  ReportRun a = drive_of_scene(), b = synthetic_drive({.states = 40, .landmarks = 0});
  ReportRun blind = synthetic_drive({.states = 50, .truth = false}), late = drive_of_scene();
  for (RunState& s : late.run.states) s.time += std::chrono::hours(1);
  EXPECT_TRUE(data_of(run_page({a}))["scenes"].empty()) << "one run without a plan";
  EXPECT_TRUE(data_of(run_page({a, b, blind, late}))["scenes"].empty()) << "different truths";
  const auto scenes = data_of(run_page({a, b, blind, late, b}))["scenes"];
  ASSERT_EQ(scenes.size(), 1U);
  EXPECT_EQ(scenes[0]["runs"][0]["run"], 1);
  EXPECT_EQ(scenes[0]["runs"][1]["run"], 4);
  EXPECT_TRUE(column(scenes[0]["plan"]["wall"]["x"]).empty());
  a.run.plan = {{.kind = PlanLine::Kind::kWall, .points = {{0, 0}, {1, 1}}}};
  EXPECT_EQ(data_of(run_page({a}))["scenes"].size(), 1U);
}

TEST(Scenes, WithoutATruthRunsShareTheirFloorPlan) {
  ReportRun one = drive_of_scene(), other = drive_of_scene(), elsewhere = drive_of_scene();
  const Plan hall = {{.kind = PlanLine::Kind::kWall, .points = {{1, 2}, {3, 4}}}};
  for (ReportRun* run : {&one, &other, &elsewhere}) {
    run->run.truth.clear();
    run->run.plan = hall;
  }
  elsewhere.run.plan.front().points.front().x() = 7;
  for (RunState& state : other.run.states) state.world_T_imu.p.x() += 5;
  const nlohmann::json scenes = data_of(run_page({one, elsewhere, other}))["scenes"];
  ASSERT_EQ(scenes.size(), 2U);
  const nlohmann::json scene = scenes[0], runs = scene["runs"];
  EXPECT_FALSE(scene.contains("truth"));
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs[1]["run"], 2);
  EXPECT_FALSE(runs[0].contains("mean_nees"));
  EXPECT_FALSE(runs[0].contains("ex"));
  // Nothing is aligned: the runs are where they say.
  const double origin = scene["origin"][0];
  const auto x = column(runs[0]["x"]), other_x = column(runs[1]["x"]);
  ASSERT_EQ(x.size(), 50U);
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_NEAR(x[i] + origin, one.run.states[i].world_T_imu.p.x(), 1e-4);
    EXPECT_NEAR(other_x[i] - x[i], 5, 1e-4);
  }
  EXPECT_NEAR(column(scene["plan"]["wall"]["x"])[1] + origin, 3, 1e-4);
  one.run.plan.clear();
  EXPECT_TRUE(data_of(run_page({one, one}))["scenes"].empty());
}

}  // namespace
}  // namespace chasles
