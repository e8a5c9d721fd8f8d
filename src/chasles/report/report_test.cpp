#include <cmath>
#include <limits>
#include <regex>

#include <gtest/gtest.h>

#include <chasles/error.hpp>
#include <chasles/report/encode.hpp>
#include <chasles/report/report.hpp>
#include <chasles/report/testing.hpp>

namespace chasles {
namespace {

using test::column;
using test::data_of;
using test::planes_of;
using test::synthetic_drive;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

ReportRun small_drive() { return synthetic_drive({.states = 50, .landmarks = 40}); }

nlohmann::json run_of(const ReportRun& run) { return data_of(run_page({run}))["runs"][0]; }

std::string as_base64(const std::string& text) { return base64({text.begin(), text.end()}); }

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(Encode, Base64GivesTheVectorsOfRfc4648) {
  EXPECT_EQ(as_base64(""), "");
  EXPECT_EQ(as_base64("f"), "Zg==");
  EXPECT_EQ(as_base64("fo"), "Zm8=");
  EXPECT_EQ(as_base64("foo"), "Zm9v");
  EXPECT_EQ(as_base64("foob"), "Zm9vYg==");
  EXPECT_EQ(as_base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(as_base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64({0xff, 0xfb, 0xf0}), "//vw");
}

TEST(Encode, ColumnsAreLittleEndianInPlanes) {
  using namespace std::string_literals;
  EXPECT_EQ(planes_of(float_column({1.0, -2.0})), "\0\0\0\0\x80\0\x3f\xc0"s);
  EXPECT_EQ(planes_of(double_column({1.0})), "\0\0\0\0\0\0\xf0\x3f"s);
  EXPECT_EQ(planes_of(int_column({1, -1})), "\x01\xff\0\xff\0\xff\0\xff"s);
  EXPECT_EQ(float_column({1.0}).substr(0, 4), "f32:");
  EXPECT_EQ(planes_of(float_column({})), "");
  EXPECT_TRUE(std::isnan(column(float_column({kNaN}))[0]));
}

TEST(Report, HoldsTheNumbersOfTheRunToAMillimetreFarFromTheOrigin) {
  ReportRun drive = small_drive();
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

TEST(Report, SigmasAndErrorsBelongTogether) {
  ReportRun drive = small_drive();
  RunState& state = drive.run.states[20];
  state.pose_covariance.setZero();
  state.pose_covariance.diagonal() << 1e-4, 4e-4, 9e-4, 0.01, 0.04, 0.09;
  const SE3 truth = drive.run.truth[20].pose;
  state.world_T_imu = {.R = so3::exp({0, 0, -0.03}) * truth.R,
                       .p = truth.p - Eigen::Vector3d(0.1, -0.2, 0.6)};
  // Truth begins where the estimate begins, so that the placement is the identity.
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

TEST(Report, TheNeesIsMeasuredInTheCoordinatesOfTheChart) {
  ReportRun drive = small_drive();
  RunState& state = drive.run.states[20];
  drive.run.states[0].world_T_imu = drive.run.truth[0].pose;
  const SE3 estimate = state.world_T_imu;
  state.pose_covariance = 1e-2 * Matrix6d::Identity();
  // A turn about the world's origin moves the position by hat(p) theta: taken back, the twist has
  // the standard error's covariance (math.md 2.4).
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

TEST(Report, TheWorldOfTheTruthDoesNotMatter) {
  ReportRun drive = small_drive();
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

TEST(Report, TheBandsAreThoseOfChiSquare) {
  const nlohmann::json data = data_of(run_page({small_drive()}));
  // Tables of the chi-square distribution.
  EXPECT_NEAR(data["bounds"]["chi2_3_low"].get<double>(), 0.2158, 1e-4);
  EXPECT_NEAR(data["bounds"]["chi2_3_high"].get<double>(), 9.3484, 1e-4);
  EXPECT_NEAR(data["bounds"]["chi2_6_high"].get<double>(), 14.4494, 1e-4);
  ReportRun run = small_drive();
  run.run.states[5].nis_dof = 3;
  run.run.states[6].nis_dof = 0;
  const nlohmann::json states = run_of(run)["states"];
  EXPECT_NEAR(column(states["nis_high"])[5], 9.3484 / 3, 1e-4);
  EXPECT_TRUE(std::isnan(column(states["nis_high"])[6]));
}

TEST(Report, HostileNamesStayText) {
  const std::string hostile =
      "</script><script>window.hostile=1</script><img src=x onerror=alert(1)>"
      "<!-- & \"quotes\" 'and' \\ \xe2\x80\xa8 " +
      std::string(5000, 'w');
  ReportRun drive = small_drive();
  const std::string benign_page = run_page({drive});
  drive.run.name = hostile;
  drive.run.extra_names[0] = hostile;
  drive.run.states[3].health = hostile;
  drive.summary = nlohmann::json{{"remarks", {hostile}}, {hostile, hostile}}.dump();
  const std::string page = run_page({drive});
  for (const char* what : {"<script", "</script", "<img", "<!--"}) {
    EXPECT_EQ(count(page, what), count(benign_page, what)) << what;
  }
  const nlohmann::json run = data_of(page)["runs"][0];
  EXPECT_EQ(run["name"], hostile);
  EXPECT_EQ(run["summary"]["remarks"][0], hostile);
  EXPECT_EQ(run["health_names"][1], hostile);
}

TEST(Report, ANameThatIsNotUtf8IsShownWithReplacements) {
  ReportRun drive = small_drive();
  drive.run.name = "drive \xff\xfe";
  EXPECT_EQ(run_of(drive)["name"], "drive \xef\xbf\xbd\xef\xbf\xbd");
}

TEST(Report, TheSameRunsGiveTheSameBytes) {
  EXPECT_EQ(run_page({small_drive(), small_drive()}), run_page({small_drive(), small_drive()}));
}

TEST(Report, TheLivePageMayAskItsOwnServerAndNothingElse) {
  const std::string page = live_page();
  EXPECT_EQ(count(page, "content=\"default-src 'none'; connect-src 'self'; script-src"), 1U);
  EXPECT_EQ(data_of(page), nlohmann::json({{"live", true}}));
  EXPECT_EQ(count(run_page({small_drive()}), "connect-src"), 0U);
}

TEST(Report, LoadsNothing) {
  const std::string page = run_page({small_drive()});
  // Libraries name addresses in their messages; what would load something is an element or a style.
  EXPECT_FALSE(
      std::regex_search(page, std::regex("<(link|img|iframe)|<script[^>]* src|@import|url\\(")));
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(page.find("@PAGE_"), std::string::npos);
}

TEST(Report, AThousandFramesAndSevenThousandLandmarksStayBelowOneAndAHalfMegabytes) {
  const ReportRun drive = synthetic_drive({.states = 1100, .landmarks = 7000});
  ASSERT_EQ(drive.run.landmarks.size(), 7000U);
  EXPECT_LT(run_page({drive}).size(), 1'500'000U);
}

// 20 frames a second.
TEST(Report, TenMinutesStayBelowFifteenMegabytes) {
  const ReportRun drive = synthetic_drive({.states = 12000, .landmarks = 20000});
  ASSERT_EQ(drive.run.states.size(), 12000U);
  const std::size_t size = run_page({drive}).size();
  RecordProperty("bytes", std::to_string(size));
  EXPECT_LT(size, 15'000'000U);
}

TEST(Report, WithoutTruthThereAreNoErrors) {
  ReportRun drive = synthetic_drive({.states = 50, .truth = false, .dead_reckoning = false});
  const nlohmann::json run = run_of(drive);
  EXPECT_FALSE(run.contains("truth"));
  EXPECT_FALSE(run.contains("errors"));
  EXPECT_FALSE(run.contains("dead_reckoning"));
  EXPECT_TRUE(run["states"].contains("sigma_px"));
}

TEST(Report, TruthThatCannotBeComparedIsShownWithTheReason) {
  ReportRun drive = small_drive();
  for (StampedPose& s : drive.run.truth) s.time += std::chrono::hours(1);
  const nlohmann::json run = run_of(drive);
  EXPECT_FALSE(run.contains("errors"));
  EXPECT_FALSE(run["truth_problem"].get<std::string>().empty());
}

TEST(Report, ALandmarkThatIsNotFiniteIsCountedNotDrawn) {
  ReportRun drive = small_drive();
  drive.run.landmarks[7].p_world.x() = kNaN;
  drive.run.landmarks[9].covariance(1, 1) = std::numeric_limits<double>::infinity();
  const nlohmann::json run = run_of(drive);
  EXPECT_EQ(column(run["landmarks"]["id"]).size(), 38U);
  EXPECT_EQ(run["landmarks_left_out"], 2);
}

TEST(Report, OneStateOrNoneIsAPage) {
  for (const int states : {0, 1}) {
    ReportRun drive = small_drive();
    drive.run.states.resize(static_cast<std::size_t>(states));
    drive.run.landmarks.clear();
    EXPECT_EQ(column(run_of(drive)["states"]["t"]).size(), static_cast<std::size_t>(states));
  }
}

/// As if an IMU's bias had been estimated: the world is level.
void make_level(ReportRun& drive) {
  drive.run.extra_names = {"accelerometer_bias_x"};
  for (RunState& state : drive.run.states) {
    state.extra = {0.01};
    state.extra_sigma = {0.02};
  }
}

TEST(Report, RunsOfOneRecordingArePlacedOnTheTruthByPositionAndYaw) {
  ReportRun one = small_drive(), other = small_drive();
  one.label = "one";
  one.summary = other.summary = R"({"chart": "standard"})";
  make_level(one);
  make_level(other);
  // In a world of its own, turned about the vertical, and 0.2 m too high in every second state: the
  // fit takes away all but 0.1 m, up and down.
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

TEST(Report, WithAnImuAnErrorOfTheFirstTiltIsNoErrorOfLaterOnes) {
  ReportRun drive = small_drive();
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
      << "where no gravity tells, the world is the first pose's";
  make_level(drive);
  EXPECT_NEAR(mean_nees(), 1.0 / 50, 1e-6);
}

TEST(Report, OnlyRunsOfOneTruthOrWithAPlanMakeAScene) {
  ReportRun a = small_drive(), b = synthetic_drive({.states = 40, .landmarks = 0});
  ReportRun blind = synthetic_drive({.states = 50, .truth = false}), late = small_drive();
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

TEST(Report, SaysWhatIsWrongWithItsInput) {
  EXPECT_THROW(run_page({}), UsageError);
  ReportRun drive = small_drive();
  drive.summary = "[1, 2";
  EXPECT_THROW(run_page({drive}), InputError);
  EXPECT_THROW(write_page({small_drive()}, "/dev/null/page.html"), InputError);
}

}  // namespace
}  // namespace chasles
