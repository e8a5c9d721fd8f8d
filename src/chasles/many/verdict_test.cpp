#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chasles/codec/text_file.hpp>
#include <chasles/many/verdict.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

Json healthy() {
  return {{"health", "ok"},
          {"coverage", 0.95},
          {"frames", 100},
          {"resets", 0},
          {"frames_not_ok", 0},
          {"nis_per_dof", 0.5},
          {"imu", {{"used", 1000}, {"gaps", 0}}}};
}

PathFigures exact_path() {
  return {.path = "states", .coverage = 0.95, .length_m = 10, .worst_sigma_m = 0.02};
}

std::vector<std::string> kinds(const std::vector<Reason>& reasons) {
  std::vector<std::string> names;
  for (const Reason& reason : reasons) names.push_back(reason.kind);
  return names;
}

std::vector<std::string> against(const Json& summary,
                                 const std::optional<PathFigures>& path = exact_path(),
                                 bool in_map = false, const CheckReport& check = {}) {
  return kinds(reasons_against(summary, path, in_map, check, {}));
}

using Names = std::vector<std::string>;

// The page has the list of the program.
TEST(Verdict, TheReasonsAreDocumented) {
  const std::string page = read_text(std::filesystem::path(CHASLES_SOURCE_DIR) / "docs/many.md");
  for (const ReasonKind& kind : reason_kinds()) {
    const std::string row = std::string("| `") + kind.name + "` | " + name_of(kind.verdict) +
                            " | " + kind.meaning + " |";
    EXPECT_NE(page.find(row), std::string::npos) << row;
  }
}

TEST(Verdict, NothingSpeaksAgainstAHealthyRun) {
  EXPECT_EQ(against(healthy()), Names{});
  EXPECT_EQ(verdict_of(std::span<const Reason>{}), Verdict::kUse);
}

TEST(Verdict, EachFigureBeyondItsLimitIsAReason) {
  const auto with = [](const char* name, const Json& value) {
    Json summary = healthy();
    summary[name] = value;
    return against(summary);
  };
  EXPECT_EQ(with("health", "lost"), Names{"lost"});
  EXPECT_EQ(with("resets", 2), Names{"degraded"});
  EXPECT_EQ(with("nis_per_dof", 2.5), Names{"innovations"});
  EXPECT_EQ(with("nis_per_dof", nullptr), Names{});
  EXPECT_EQ(with("imu", {{"used", 1000}, {"gaps", 1}}), Names{"imu"});
  EXPECT_EQ(with("imu", {{"used", 1000}, {"saturated", 2}}), Names{}) << "a few are bridged";
  EXPECT_EQ(with("imu", {{"used", 1000}, {"saturated", 3}}), Names{"imu"});
  EXPECT_EQ(with("frontend", {{"frames", 100}, {"unreadable", 1}}), Names{});
  EXPECT_EQ(with("frontend", {{"frames", 100}, {"unreadable", 2}}), Names{"images"});
  const auto moved = [&](double estimate) {
    const Json parameter{{"name", "fx"},
                         {"unit", "px"},
                         {"stated", 400},
                         {"stated_sigma", 2},
                         {"estimate", estimate}};
    return with("calibration", {{"parameters", Json::array({parameter})}});
  };
  EXPECT_EQ(moved(407), Names{});
  EXPECT_EQ(moved(409), Names{"calibration"});
}

TEST(Verdict, TheCoverageIsThatOfThePath) {
  const auto with = [](double coverage) {
    PathFigures path = exact_path();
    path.coverage = coverage;
    return against(healthy(), path);
  };
  EXPECT_EQ(with(0.7), Names{"coverage"});
  EXPECT_EQ(with(0.4), Names{"few_estimates"});
}

TEST(Verdict, ACovarianceThatIsNotFiniteIsNoSigmaOfZero) {
  PathFigures path = exact_path();
  path.worst_sigma_m = std::numeric_limits<double>::infinity();
  EXPECT_EQ(against(healthy(), path), Names{"uncertain"});
}

TEST(Verdict, ALongPathMayBeMoreUncertain) {
  PathFigures path = exact_path();
  path.worst_sigma_m = 0.5;
  EXPECT_EQ(against(healthy(), path), Names{"uncertain"});
  path.length_m = 60;
  EXPECT_EQ(against(healthy(), path), Names{});
}

TEST(Verdict, ARunInAMapNeedsItsPlace) {
  EXPECT_EQ(against(healthy(), std::nullopt, true), Names{"no_place"});
}

TEST(Verdict, FindingsOfACheckAreReasonsByTheirSeverity) {
  const auto finding = [](Severity severity, const char* what) {
    Finding made;
    made.severity = severity;
    made.about = "cam0";
    made.what = what;
    return made;
  };
  CheckReport check;
  check.findings = {finding(Severity::kNote, "a"), finding(Severity::kWarning, "b"),
                    finding(Severity::kError, "c"), finding(Severity::kWarning, "d")};
  const std::vector<Reason> reasons = reasons_against(healthy(), exact_path(), false, check, {});
  EXPECT_EQ(kinds(reasons), (Names{"check_error", "check_warning"}));
  EXPECT_EQ(reasons[0].what, "cam0: c");
  EXPECT_EQ(reasons[1].what, "cam0: b; cam0: d");
  EXPECT_EQ(verdict_of(reasons), Verdict::kCheck);
  EXPECT_EQ(verdict_of(reason_of(InputError("x"))), Verdict::kNo);
}

TEST(Verdict, AnErrorIsAReasonByItsCode) {
  EXPECT_EQ(reason_of(UsageError("x")).kind, "settings");
  EXPECT_EQ(reason_of(InputError("x")).kind, "unreadable");
  EXPECT_EQ(reason_of(Error(ExitCode::kNotInitialised, "x")).kind, "not_initialised");
  EXPECT_EQ(reason_of(Error(ExitCode::kDiverged, "x")).kind, "lost");
}

// A pose whose position has the standard deviations (1, 2, 3) cm along turned axes.
RunState turned_state(double x, double scale, const char* health) {
  RunState state;
  state.world_T_imu.p = {x, 0, 0};
  const Eigen::Matrix3d R = so3::exp(Eigen::Vector3d(0.3, -0.2, 0.5));
  const Eigen::Vector3d variances(1e-4, 4e-4, 9e-4);
  state.pose_covariance.bottomRightCorner<3, 3>() =
      scale * scale * R * variances.asDiagonal() * R.transpose();
  state.pose_covariance.topLeftCorner<3, 3>() = Eigen::Matrix3d::Identity() * 1e-6;
  state.health = health;
  return state;
}

constexpr FrameCoverage kAll{.estimated = 3, .frames = 4};

TEST(PathFigures, TheWorstAxisOfTheWorstPoseThatIsNotLostCounts) {
  chasles::Run run;
  run.states = {turned_state(0, 1, "ok"), turned_state(2, 2, "degraded"),
                turned_state(4, 9, "lost")};
  const std::optional<PathFigures> path = path_figures(run, kAll, false);
  ASSERT_TRUE(path);
  EXPECT_EQ(path->path, "states");
  EXPECT_EQ(path->poses, 2u);
  EXPECT_NEAR(path->worst_sigma_m, 0.06, 1e-12);
  EXPECT_NEAR(path->length_m, 2, 1e-12);
  EXPECT_NEAR(path->drift_m_per_100m, 3, 1e-10);
  EXPECT_NEAR(path->worst_turn_deg, 1e-3 * 180 / std::numbers::pi, 1e-12);
}

TEST(PathFigures, SmoothedPosesComeBeforeStatesAndThoseOfAMapBeforeAll) {
  chasles::Run run;
  run.states = {turned_state(0, 1, "ok")};
  EXPECT_FALSE(path_figures(run, kAll, true)) << "without a place there is no pose in the map";
  run.smoothed = {{.world_T_imu = {}, .pose_covariance = Matrix6d::Identity()}};
  EXPECT_EQ(path_figures(run, kAll, false)->path, "smoothed");
  run.in_map = run.smoothed;
  EXPECT_EQ(path_figures(run, kAll, true)->path, "in_map");
  EXPECT_EQ(path_figures(run, kAll, true)->coverage, 0.25) << "a place that was found late";
  EXPECT_EQ(path_figures(run, kAll, false)->coverage, 0.75);
  run.smoothed[0].pose_covariance(4, 4) = std::nan("");
  EXPECT_TRUE(std::isinf(path_figures(run, kAll, false)->worst_sigma_m));
  EXPECT_FALSE(path_figures(chasles::Run{}, kAll, false));
}

}  // namespace
}  // namespace chasles
