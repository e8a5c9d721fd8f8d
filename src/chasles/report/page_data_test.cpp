#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <chasles/base/constants.hpp>
#include <chasles/report/report.hpp>
#include <chasles/report/testing.hpp>

namespace chasles {
namespace {

using test::column;
using test::data_of;
using test::synthetic_drive;

ReportRun drive_on_page() { return synthetic_drive({.states = 50, .landmarks = 40}); }

nlohmann::json run_of(const ReportRun& run) { return data_of(run_page({run}))["runs"][0]; }

TEST(PageData, HoldsTheNumbersOfTheRunToAMillimetreFarFromTheOrigin) {
  ReportRun drive = drive_on_page();
  const Eigen::Vector3d utm(455'123.25, 5'412'877.5, 117);
  for (RunState& s : drive.run.states) s.world_T_imu.p += utm;
  for (RunLandmark& m : drive.run.landmarks) m.p_world += utm;
  drive.run.landmarks[3].id = 1LL << 40;
  const nlohmann::json run = run_of(drive);
  const auto x = column(run["states"]["x"]), y = column(run["landmarks"]["y"]);
  const auto t = column(run["states"]["t"]), cxz = column(run["landmarks"]["cxz"]);
  ASSERT_EQ(x.size(), 50U);
  ASSERT_EQ(y.size(), 40U);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const RunState& s = drive.run.states[i];
    EXPECT_NEAR(x[i] + run["origin"][0].get<double>(), s.world_T_imu.p.x(), 1e-3);
    EXPECT_NEAR(t[i], to_seconds(s.time - drive.run.states[0].time), 1e-5);
    EXPECT_EQ(column(run["states"]["used"])[i], s.used);
  }
  for (std::size_t i = 0; i < y.size(); ++i) {
    EXPECT_NEAR(y[i] + run["origin"][1].get<double>(), drive.run.landmarks[i].p_world.y(), 1e-3);
    EXPECT_NEAR(cxz[i], drive.run.landmarks[i].covariance(0, 2), 1e-6);
  }
  EXPECT_EQ(column(run["landmarks"]["id"])[3], std::exp2(40));
}

TEST(PageData, TheMapLiesInTheWorldOfTheRun) {
  const ReportRun drive = synthetic_drive({.states = 50, .landmarks = 40, .prior_map = true});
  const nlohmann::json run = run_of(drive), map = run["map"], marks = map["marks"];
  EXPECT_EQ(map["sessions"][1]["name"], "Tuesday");
  EXPECT_EQ(map["sessions"][0]["seconds"], 90);
  const auto x = column(marks["x"]), y = column(marks["y"]), cxz = column(marks["cxz"]),
             own = column(marks["own"]);
  ASSERT_EQ(y.size(), 40U);
  for (std::size_t i = 0; i < y.size(); ++i) {
    const RunLandmark& l = drive.run.landmarks[i];
    // The run has its own estimate of every third.
    const Eigen::Vector2d shift = i % 3 == 0 ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(0.5, 3);
    EXPECT_NEAR(x[i] + run["origin"][0].get<double>(), l.p_world.x() + shift.x(), 1e-3);
    EXPECT_NEAR(y[i] + run["origin"][1].get<double>(), l.p_world.y() + shift.y(), 1e-3);
    EXPECT_NEAR(cxz[i], l.covariance(0, 2), 1e-6);
    EXPECT_NEAR(own[i], static_cast<double>(i % 10) / 10, 1e-6);
    EXPECT_EQ(column(marks["returned"])[i], i % 6 == 0 ? 1 : 0);
    EXPECT_EQ(column(marks["session"])[i], i % 4 == 0 ? 0 : 1);
  }
  EXPECT_EQ(column(run["landmarks"]["id"]).size(), 26U) << "14 are those of the map";
  EXPECT_EQ(run["landmarks_left_out"], 0);
  EXPECT_FALSE(run_of(drive_on_page()).contains("map"));
}

TEST(PageData, SigmasAndErrorsBelongTogether) {
  ReportRun drive = drive_on_page();
  RunState& state = drive.run.states[20];
  state.pose_covariance.setZero();
  state.pose_covariance.diagonal() << 1e-4, 4e-4, 9e-4, 0.01, 0.04, 0.09;
  const SE3 truth = drive.run.truth[20].pose;
  state.world_T_imu = {.R = so3::exp({0, 0, -0.03}) * truth.R,
                       .p = truth.p - Eigen::Vector3d(0.1, -0.2, 0.6)};
  // The truth starts with the estimate, so that the alignment is the identity.
  drive.run.states[0].world_T_imu = drive.run.truth[0].pose;
  const nlohmann::json run = run_of(drive);
  const auto at_20 = [&](const char* group, const char* name) {
    return column(run[group][name])[20];
  };
  const double degrees = 180 / std::acos(-1);
  EXPECT_NEAR(at_20("states", "sigma_px"), 0.1, 1e-6);
  EXPECT_NEAR(at_20("states", "sigma_rz"), 0.03 * degrees, 1e-5);
  EXPECT_NEAR(at_20("errors", "position_x"), 0.1, 1e-6);
  EXPECT_NEAR(at_20("errors", "position_y"), -0.2, 1e-6);
  EXPECT_NEAR(at_20("errors", "attitude_z"), 0.03 * degrees, 1e-5);
  EXPECT_NEAR(at_20("errors", "nees_position"), 1 + 1 + 4, 1e-4);
  EXPECT_NEAR(at_20("errors", "nees_attitude"), 1, 1e-4);
  EXPECT_NEAR(at_20("errors", "nees_pose"), 7, 1e-4);
}

TEST(PageData, TheNeesIsMeasuredInTheCoordinatesOfTheChart) {
  ReportRun drive = drive_on_page();
  RunState& state = drive.run.states[20];
  drive.run.states[0].world_T_imu = drive.run.truth[0].pose;
  const SE3 estimate = state.world_T_imu;
  state.pose_covariance = 1e-2 * Matrix6d::Identity();
  // A rotation about the world's origin moves the position by hat(p) theta. With this removed, the
  // twist has the standard error's covariance (docs/derivations.md, D14).
  Matrix6d M = Matrix6d::Identity();
  M.bottomLeftCorner<3, 3>() = -hat(estimate.p);
  const Vector6d twist = se3::log(drive.run.truth[20].pose * estimate.inverse());
  const Vector6d white = M * twist;
  for (const char* chart : {"right-se3", "right-sen3"}) {
    drive.summary = nlohmann::json{{"chart", chart}}.dump();
    const double nees = column(run_of(drive)["errors"]["nees_pose"])[20];
    EXPECT_NEAR(nees, white.squaredNorm() / 1e-2, 1e-6 * nees) << chart;
  }
  drive.summary = R"({"chart": "standard"})";
  EXPECT_EQ(run_of(drive)["nees_coordinates"], "standard");
}

TEST(PageData, TheWorldOfTheTruthDoesNotMatter) {
  ReportRun drive = drive_on_page();
  const nlohmann::json here = run_of(drive);
  const SE3 elsewhere{so3::exp({0.3, -0.8, 1.9}), {120, -40, 7}};
  for (StampedPose& s : drive.run.truth) s.pose = elsewhere * s.pose;
  const nlohmann::json there = run_of(drive);
  for (const char* name : {"first_x", "fit_y"}) {
    const auto a = column(here["truth"][name]), b = column(there["truth"][name]);
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-4) << name;
  }
  const auto a = column(here["errors"]["position_y"]), b = column(there["errors"]["position_y"]);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-5);
}

TEST(PageData, TheBandsAreThoseOfChiSquare) {
  const nlohmann::json data = data_of(run_page({drive_on_page()}));
  // Tables of the chi-square distribution.
  EXPECT_NEAR(data["bounds"]["chi2_3_low"].get<double>(), 0.2158, 1e-4);
  EXPECT_NEAR(data["bounds"]["chi2_3_high"].get<double>(), 9.3484, 1e-4);
  EXPECT_NEAR(data["bounds"]["chi2_6_high"].get<double>(), 14.4494, 1e-4);
  ReportRun run = drive_on_page();
  run.run.states[5].nis_dof = 3;
  run.run.states[6].nis_dof = 0;
  const nlohmann::json states = run_of(run)["states"];
  EXPECT_NEAR(column(states["nis_high"])[5], 9.3484 / 3, 1e-4);
  EXPECT_TRUE(std::isnan(column(states["nis_high"])[6]));
}

TEST(PageData, WithoutTruthThereAreNoErrors) {
  ReportRun drive = synthetic_drive({.states = 50, .truth = false, .dead_reckoning = false});
  const nlohmann::json run = run_of(drive);
  EXPECT_FALSE(run.contains("truth"));
  EXPECT_FALSE(run.contains("errors"));
  EXPECT_FALSE(run.contains("dead_reckoning"));
  EXPECT_TRUE(run["states"].contains("sigma_px"));
}

TEST(PageData, TruthThatCannotBeComparedIsShownWithTheReason) {
  ReportRun drive = drive_on_page();
  for (StampedPose& s : drive.run.truth) s.time += std::chrono::hours(1);
  const nlohmann::json run = run_of(drive);
  EXPECT_FALSE(run.contains("errors"));
  EXPECT_FALSE(run["truth_problem"].get<std::string>().empty());
}

TEST(PageData, StatesThatAreNotFiniteLeaveTheComparisonOfTheOthers) {
  ReportRun drive = drive_on_page();
  const nlohmann::json whole = run_of(drive);
  drive.run.states[7].world_T_imu.p.x() = kNaN;
  drive.run.states[8].world_T_imu.R.setConstant(kNaN);
  const nlohmann::json run = run_of(drive);
  const auto errors = column(run["errors"]["position_y"]);
  EXPECT_TRUE(std::isnan(errors[7]) && std::isnan(errors[8]));
  EXPECT_EQ(errors[9], column(whole["errors"]["position_y"])[9]);
  EXPECT_EQ(column(run["errors"]["nees_pose"])[30], column(whole["errors"]["nees_pose"])[30]);
  for (const double x : column(run["truth"]["fit_x"])) EXPECT_TRUE(std::isfinite(x));
}

TEST(PageData, ALandmarkThatIsNotFiniteIsCountedNotDrawn) {
  ReportRun drive = drive_on_page();
  drive.run.landmarks[7].p_world.x() = kNaN;
  drive.run.landmarks[9].covariance(1, 1) = std::numeric_limits<double>::infinity();
  const nlohmann::json run = run_of(drive);
  EXPECT_EQ(column(run["landmarks"]["id"]).size(), 38U);
  EXPECT_EQ(run["landmarks_left_out"], 2);
}

TEST(PageData, InitialPositionsAreGivenWhereTheyAreKnown) {
  ReportRun drive = drive_on_page();
  EXPECT_FALSE(run_of(drive)["landmarks"].contains("ix"));
  RunLandmark& known = drive.run.landmarks[3];
  known.initial = {.p_world = known.p_world + Eigen::Vector3d(1, 2, 3),
                   .covariance = Eigen::Matrix3d::Identity()};
  const nlohmann::json landmarks = run_of(drive)["landmarks"];
  for (const auto& [name, shift] :
       {std::pair{"x", 1.0}, std::pair{"y", 2.0}, std::pair{"z", 3.0}}) {
    const auto initial = column(landmarks[std::string("i") + name]);
    EXPECT_NEAR(initial[3] - column(landmarks[name])[3], shift, 1e-3) << name;
    EXPECT_TRUE(std::isnan(initial[4]));
  }
}

TEST(PageData, OneStateOrNoneIsAPage) {
  for (const int states : {0, 1}) {
    ReportRun drive = drive_on_page();
    drive.run.states.resize(static_cast<std::size_t>(states));
    drive.run.landmarks.clear();
    EXPECT_EQ(column(run_of(drive)["states"]["t"]).size(), static_cast<std::size_t>(states));
  }
}

TEST(PageData, ANameThatIsNotUtf8IsShownWithReplacements) {
  ReportRun drive = drive_on_page();
  drive.run.name = "drive \xff\xfe";
  EXPECT_EQ(run_of(drive)["name"], "drive \xef\xbf\xbd\xef\xbf\xbd");
}

}  // namespace
}  // namespace chasles
