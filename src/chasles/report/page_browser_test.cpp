#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>
#include <unistd.h>

#include <gtest/gtest.h>

#include <chasles/codec/text_file.hpp>
#include <chasles/report/batch_page.hpp>
#include <chasles/report/calibration_page.hpp>
#include <chasles/report/calibration_page_testing.hpp>
#include <chasles/report/testing.hpp>

namespace chasles {
namespace {

using test::synthetic_drive;

/// Opens the page in headless Chromium and uses it (a script in src/web/tests, with its choice of
/// steps). With CHASLES_PAGES set the pages and their pictures stay in that folder.
void expect_page_works(const std::string& text, const std::string& name, const std::string& script,
                       const std::string& steps = "") {
  const char* kept = std::getenv("CHASLES_PAGES");
  const auto folder = kept ? std::filesystem::path(kept)
                           : std::filesystem::temp_directory_path() /
                                 ("chasles_page_test_" + std::to_string(getpid()));
  const auto page = folder / (name + ".html");
  make_folder(folder);
  write_file(page, text);
  const std::string command = "'" CHASLES_NODE "' '" CHASLES_SOURCE_DIR "/src/web/tests/" + script +
                              "' '" + page.string() + "' '" + (folder / name).string() + "' " +
                              steps;
  const int status = std::system(command.c_str());
  if (!kept) std::filesystem::remove_all(folder);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 77) GTEST_SKIP() << "skipped: no Chromium";
  EXPECT_EQ(status, 0);
}

void expect_works_in_a_browser(const std::vector<ReportRun>& runs, const std::string& name,
                               const std::string& script = "run_page.mjs",
                               const std::string& steps = "") {
  expect_page_works(run_page(runs), name, script, steps);
}

// Recordings with every verdict, hostile names, and an earlier batch.
TEST(PageInABrowser, ABatchIsListedWorstFirst) {
  using Json = nlohmann::ordered_json;
  chasles::Run pictures = synthetic_drive({.states = 60, .landmarks = 10}).run;
  test::add_synthetic_images(pictures, 30);
  const std::string hostile = "<img src=x onerror='window.hostile=1'></script>";
  std::vector<BatchRow> rows;
  for (int i = 0; i < 30; ++i) {
    const bool is_no = i % 10 == 3, is_check = i % 10 == 5;
    Json record{{"name", "walk-" + std::to_string(i)},
                {"recording", "/data/walk-" + std::to_string(i)},
                {"verdict", is_no      ? "no"
                            : is_check ? "check"
                                       : "use"},
                {"reasons", Json::array()}};
    if (is_no) record["reasons"].push_back({{"reason", "unreadable"}, {"what", hostile}});
    if (is_check) record["reasons"].push_back({{"reason", "uncertain"}, {"what", "0.2 m"}});
    if (!is_no) {
      record.update({{"coverage", 0.9},
                     {"recorded_seconds", 12.5},
                     {"length_m", 10 + i},
                     {"worst_sigma_m", 0.01 * i},
                     {"drift_m_per_100m", 0.1},
                     {"sketch", {{"x", {0, 1, 2}}, {"y", {0, 0.5, i}}}}});
    }
    rows.push_back({record, is_no ? "" : pictures.images.front().jpeg});
  }
  const Json summary{{"recordings", 30},
                     {"verdicts", {{"use", 24}, {"check", 3}, {"no", 3}}},
                     {"reasons", {{"unreadable", 3}, {"uncertain", 3}}},
                     {"recorded_seconds", 337.5},
                     {"length_m", 700},
                     {"plan", {{"version", "1"}, {"estimator", "filter"}}}};
  const Json difference{
      {"worse", {{{"name", hostile}, {"before", "use"}, {"now", "no"}}}},
      {"better", {{{"name", "walk-1"}, {"before", "check"}, {"now", "use"}}}},
      {"only_before", Json::array()},
      {"only_now", {"walk-2"}},
      {"figures",
       {{"worst_sigma_m", {{"pairs", 27}, {"ratio", 0.9}, {"low", 0.8}, {"high", 1.1}}},
        {"ate_posyaw_m", {{"pairs", 1}, {"ratio", 0.9}, {"low", nullptr}, {"high", nullptr}}}}}};
  expect_page_works(batch_page(summary, rows, difference), "batch", "batch_page.mjs");
}

TEST(PageInABrowser, ACalibrationOfCamerasIsDrawnAndAnswers) {
  nlohmann::ordered_json calibration = test::two_cameras_json();
  const std::string hostile = "<img src=x onerror='window.hostile=1'></script>";
  calibration["remarks"] = {hostile};
  calibration["cameras"][0]["lenses"][1]["fault"] = hostile;
  expect_page_works(cameras_page(calibration, test::synthetic_views()), "calibration",
                    "calibration_page.mjs", "cameras");
}

TEST(PageInABrowser, ACalibrationOfNoiseIsDrawnAndAnswers) {
  const auto term = [](double value) {
    return nlohmann::ordered_json{{"value", value}, {"sigma", value / 50}, {"limit", value}};
  };
  const nlohmann::ordered_json limit{{"value", nullptr}, {"sigma", nullptr}, {"limit", 1e-5}};
  nlohmann::ordered_json noise{{"recording", "desk <b>"},
                               {"samples", 240000},
                               {"rate_hz", 200},
                               {"seconds", 1200},
                               {"standstill", {{"seconds", 1150}}},
                               {"remarks", {"<img src=x onerror='window.hostile=1'>"}}};
  std::vector<AllanCurve> curves;
  for (const char* sensor : {"accelerometer", "gyroscope"}) {
    noise[sensor] = {{"unit", "rad/s"},
                     {"noise_density", {{"value", 1.7e-4}, {"is_limit", false}}},
                     {"random_walk", {{"value", 2e-5}, {"is_limit", true}}},
                     {"axes", nlohmann::ordered_json::array()}};
    for (const char* axis : {"x", "y", "z"}) {
      noise[sensor]["axes"].push_back({{"axis", axis},
                                       {"noise_density", term(1.7e-4)},
                                       {"bias_instability", limit},
                                       {"random_walk", term(2e-5)}});
      AllanCurve curve{.sensor = sensor,
                       .axis = axis,
                       .seconds = {},
                       .deviation = {},
                       .lowest = {},
                       .highest = {},
                       .of_fit = {}};
      for (double tau = 0.005; tau < 500; tau *= 1.5) {
        curve.seconds.push_back(tau);
        curve.of_fit.push_back(std::hypot(1.7e-4 / std::sqrt(tau), 2e-5 * std::sqrt(tau / 3)));
        curve.deviation.push_back(1.05 * curve.of_fit.back());
        curve.lowest.push_back(0.9 * curve.of_fit.back());
        curve.highest.push_back(1.2 * curve.of_fit.back());
      }
      curves.push_back(std::move(curve));
    }
  }
  expect_page_works(noise_page(noise, curves), "noise", "calibration_page.mjs", "noise");
}

// A drive that ends at a standstill, where nothing is used.
TEST(PageInABrowser, ADriveIsDrawnAndAnswers) {
  ReportRun drive = synthetic_drive({.initial = true});
  auto& states = drive.run.states;
  for (std::size_t i = states.size() - 15; i < states.size(); ++i) {
    states[i].used = 0;
    states[i].world_T_imu = states[i - 1].world_T_imu;
  }
  expect_works_in_a_browser({drive}, "drive");
}

TEST(PageInABrowser, AMapIsDrawnBySession) {
  ReportRun map{.run = {}, .summary = R"({"version": "1", "bytes": 200000, "shared_errors": 7,
                "least_m": [0, -20.5, 1], "most_m": [90, 30, 4]})"};
  map.run.name = "hall <b>.map";
  map.run.prior_map = test::synthetic_map(synthetic_drive({.landmarks = 400}).run.landmarks);
  map.run.prior_map->world_T_map = {};
  expect_page_works(map_page(map), "map", "map_page.mjs");
}

TEST(PageInABrowser, KeptImagesAreShownWithWhatWasSeenInThem) {
  ReportRun run = synthetic_drive({.states = 400, .landmarks = 300, .prior_map = true});
  test::add_synthetic_images(run.run, 20);
  run.run.extra_names = {"velocity_x",       "velocity_y",       "velocity_z",
                         "gyroscope_bias_x", "gyroscope_bias_y", "gyroscope_bias_z"};
  expect_works_in_a_browser({run}, "images", "run_page.mjs",
                            "scene mapMoves landmarkLives exports camera print");
}

TEST(PageInABrowser, SeveralRunsWithHostileNamesAreCompared) {
  ReportRun hostile = synthetic_drive({.states = 300, .landmarks = 200, .seed = 2});
  hostile.run.name =
      "</script><script>window.hostile=1</script><img src=x onerror=alert(1)> & \"q\" " +
      std::string(300, 'w');
  hostile.run.extra_names[0] = "<b>bold</b>";
  ReportRun other = synthetic_drive({.states = 300, .landmarks = 0, .seed = 3, .truth = false});
  other.summary =
      R"({"settings": {"chart": "standard"}, "remarks": ["<i>x</i>"], "health": "lost"})";
  expect_works_in_a_browser({hostile, other}, "several");
}

// Five runs of one recording with a floor plan. One starts later, and has fewer frames.
std::vector<ReportRun> runs_over_a_plan() {
  std::vector<ReportRun> runs(5, synthetic_drive({.states = 600, .landmarks = 50}));
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const char* charts[] = {"standard", "left-se3", "right-se3", "right-sen3", "right-sen3"};
    runs[k].summary = std::string(R"({"nees_pose": 7.5, "ate_posyaw_m": 0.2, "resets": 0, )") +
                      R"("settings": {"interval": )" + std::to_string(k / 4) + R"(, "chart": ")" +
                      charts[k] + "\"}}";
    runs[k].label = "<b>" + std::to_string(k) + std::string(k == 2 ? 90 : 1, 'w');
    for (RunState& s : runs[k].run.states) s.world_T_imu.p.y() += 0.8 * static_cast<double>(k);
    runs[k].run.plan = {
        {.kind = PlanLine::Kind::kWall,
         .points = {{-20, -30}, {250, -30}, {250, 150}, {-20, 150}, {-20, -30}}},
        {.kind = PlanLine::Kind::kFurniture, .points = {{50, 20}, {60, 20}, {60, 30}, {50, 20}}}};
  }
  runs[3].run.states.erase(runs[3].run.states.begin(), runs[3].run.states.begin() + 77);
  return runs;
}

TEST(PageInABrowser, RunsOfOneRecordingAreShownOverItsPlan) {
  expect_works_in_a_browser(runs_over_a_plan(), "overview", "run_page.mjs",
                            "scene mapMoves overview otherRuns");
}

TEST(PageInABrowser, WithoutATruthRunsAreShownOverTheirPlan) {
  std::vector<ReportRun> runs = runs_over_a_plan();
  for (ReportRun& run : runs) run.run.truth.clear();
  expect_works_in_a_browser(runs, "plan-alone", "run_page.mjs", "axes overview otherRuns");
}

// The page that src/web/tests/frame_rate.mjs measures (docs/CONTRIBUTING.md).
TEST(PageInABrowser, ALongRunIsDrawnCoarselyInMotionAndInFullWithoutIt) {
  expect_works_in_a_browser({synthetic_drive({.states = 100'000, .landmarks = 20'000})}, "long",
                            "long_page.mjs");
}

TEST(PageInABrowser, NoStateOneStateAndStatesThatAreNotFiniteLeaveAPage) {
  const ReportRun none = synthetic_drive({.states = 0, .landmarks = 0});
  const ReportRun one = synthetic_drive({.states = 1, .landmarks = 1});
  ReportRun lost = synthetic_drive({.states = 60, .landmarks = 20});
  for (std::size_t i = 20; i < 60; ++i) {
    lost.run.states[i].world_T_imu.p.setConstant(std::numeric_limits<double>::quiet_NaN());
    lost.run.states[i].pose_covariance.setConstant(std::numeric_limits<double>::infinity());
  }
  ReportRun away = synthetic_drive({.states = 60, .landmarks = 20});
  for (std::size_t i = 20; i < 60; ++i) away.run.states[i].world_T_imu.p.setConstant(1e30);
  expect_works_in_a_browser({none, one, lost, away}, "few", "few_page.mjs");
}

TEST(PageInABrowser, AbsentTruthDeadReckoningLandmarksAndSummaryLeaveAPage) {
  ReportRun bare =
      synthetic_drive({.states = 200, .landmarks = 0, .truth = false, .dead_reckoning = false});
  bare.summary.clear();
  bare.run.extra_names.clear();
  bare.run.name.clear();
  expect_works_in_a_browser({bare}, "bare");
}

}  // namespace
}  // namespace chasles
