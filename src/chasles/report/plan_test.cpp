#include <cmath>

#include <gtest/gtest.h>

#include <chasles/report/testing.hpp>

// The floor plan in a run's own world.
namespace chasles {
namespace {

using test::column;

TEST(RunPlan, LiesWhereTheTruthIsPlaced) {
  ReportRun drive = test::synthetic_drive({.states = 50, .landmarks = 5});
  // The estimate is the truth in another world, except for a first pose that is 0.5 m off.
  const SE3 elsewhere{so3::exp({0, 0, 1.1}), {30, -7, 2}};
  const Eigen::Vector3d off(0.5, 0, 0);
  for (std::size_t i = 0; i < drive.run.states.size(); ++i) {
    drive.run.states[i].world_T_imu = elsewhere * drive.run.truth[i].pose;
  }
  drive.run.states.front().world_T_imu.p += off;
  drive.run.plan = {{.kind = PlanLine::Kind::kWall, .points = {{1, 2}, {3, 4}}},
                    {.kind = PlanLine::Kind::kFurniture, .points = {{5, 6}, {7, 8}, {9, 9}}}};
  const nlohmann::json run = test::data_of(run_page({drive}))["runs"][0];
  const auto at = [&](const char* kind, const std::string& placed, std::size_t i) {
    const nlohmann::json& columns = run["plan"][kind];
    return Eigen::Vector3d(column(columns[placed + "x"])[i], column(columns[placed + "y"])[i],
                           column(columns[placed + "z"])[i]);
  };
  const Eigen::Vector3d origin = drive.run.states.front().world_T_imu.p;
  const double height = drive.run.truth.front().pose.p.z();
  const Eigen::Vector3d exact = elsewhere * Eigen::Vector3d(3, 4, height) - origin;
  EXPECT_LT((at("wall", "first_", 1) - exact - off).norm(), 1e-3);
  EXPECT_LT((at("wall", "fit_", 1) - exact).norm(), 0.1) << "one pose of fifty draws it little";
  EXPECT_GT((at("wall", "fit_", 1) - exact - off).norm(), 0.3);
  EXPECT_TRUE(std::isnan(at("wall", "first_", 2).x())) << "a line ends";
  EXPECT_EQ(column(run["plan"]["furniture"]["fit_z"]).size(), 4U);
}

TEST(RunPlan, ATruthThatDoesNotFitDoesNotPlaceIt) {
  ReportRun drive = test::synthetic_drive({.states = 20, .landmarks = 0});
  EXPECT_FALSE(test::data_of(run_page({drive}))["runs"][0].contains("plan"));
  drive.run.plan = {{.kind = PlanLine::Kind::kWall, .points = {{1, 2}, {3, 4}}}};
  EXPECT_TRUE(test::data_of(run_page({drive}))["runs"][0].contains("plan"));
  for (StampedPose& s : drive.run.truth) s.time += std::chrono::hours(1);
  EXPECT_FALSE(test::data_of(run_page({drive}))["runs"][0].contains("plan"));
}

TEST(RunPlan, WithoutATruthTheRunsWorldIsThePlans) {
  ReportRun drive = test::synthetic_drive({.states = 20, .landmarks = 0});
  drive.run.truth.clear();
  drive.run.plan = {{.kind = PlanLine::Kind::kWall, .points = {{1, 2}, {3, 4}}}};
  const nlohmann::json wall = test::data_of(run_page({drive}))["runs"][0]["plan"]["wall"];
  const Eigen::Vector3d origin = drive.run.states.front().world_T_imu.p;
  for (const std::string placed : {"first_", "fit_"}) {
    EXPECT_NEAR(column(wall[placed + "x"])[1] + origin.x(), 3, 1e-4);
    EXPECT_NEAR(column(wall[placed + "y"])[1] + origin.y(), 4, 1e-4);
    EXPECT_EQ(column(wall[placed + "z"])[1], 0) << "at the height of the first pose";
  }
}

}  // namespace
}  // namespace chasles
