#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/recording/readers.hpp>

#include "cli_test.hpp"

// `chasles compare`, and the recordings of scenes with an IMU.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

// Three seconds of the turntable.
const std::string kScene = "turntable --scene-set revolutions=0.15 ";

std::size_t lines_of(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST(Compare, PrintsBothTablesForThePresets) {
  const Scratch folder;
  const Outcome outcome = chasles(folder, "compare " + kScene);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  for (const char* part : {"Average NEES", "Average error", "paper-standard", "paper-left-se3",
                           "paper-right-se3", "\ndefault ", "NIS/dof", "CPU [ms/frame]"}) {
    expect_part(outcome.out, part);
  }
}

TEST(Compare, PrintsMarkdown) {
  const Scratch folder;
  const Outcome outcome = chasles(folder, "compare " + kScene + "--preset default --markdown");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  expect_part(outcome.out, "### Average NEES");
  expect_part(outcome.out, "| filter");
}

TEST(Compare, GivesEveryCombinationByName) {
  const Scratch folder;
  const Outcome outcome =
      chasles(folder, "compare " + kScene +
                          "--charts standard,right-sen3 --landmarks cartesian,inverse-depth "
                          "--init fixed-depth --set gate=0.99 --json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json json = Json::parse(outcome.out);
  ASSERT_EQ(json.at("filters").size(), 4u);
  EXPECT_EQ(json["filters"][0]["filter"], "standard+cartesian+fixed-depth");
  EXPECT_EQ(json["filters"][3]["filter"], "right-sen3+inverse-depth+fixed-depth");
  for (const Json& filter : json["filters"]) {
    EXPECT_EQ(filter.at("settings").at("gate"), 0.99);
    EXPECT_EQ(filter.at("chart"), filter.at("settings").at("chart"));
    EXPECT_EQ(filter.at("runs"), 1);
    EXPECT_EQ(filter.at("health"), "ok");
    EXPECT_EQ(filter.at("band").size(), 2u);
    for (const char* name :
         {"ate_m", "position_error_m", "attitude_error_deg", "nees_position", "nees_attitude",
          "nees_pose", "nis_per_dof", "seconds_cpu", "milliseconds_per_frame"}) {
      EXPECT_GT(filter.at(name).get<double>(), 0) << name;
    }
    EXPECT_EQ(filter.at("covariance_too_small_by"), filter.at("nees_pose_per_dof"));
  }
  EXPECT_NE(json["filters"][0]["nees_pose"], json["filters"][3]["nees_pose"]);
}

TEST(Compare, TakesAFilterFromAFile) {
  const Scratch folder;
  spill(folder / "mine.yaml", "chart: left-se3\nclones: 9\n");
  const Outcome outcome = chasles(folder, "compare " + kScene + "--config mine.yaml --json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json filters = Json::parse(outcome.out).at("filters");
  ASSERT_EQ(filters.size(), 1u);
  EXPECT_EQ(filters[0]["filter"], "mine");
  EXPECT_EQ(filters[0]["settings"]["clones"], 9);
}

TEST(Compare, WritesTheSameFolderAgain) {
  const Scratch folder;
  const std::string arguments = "compare " + kScene + "--preset default --run 4 -o ";
  ASSERT_EQ(chasles(folder, arguments + "a").code, 0);
  ASSERT_EQ(chasles(folder, arguments + "b").code, 0);
  for (const char* file : {"default.csv", "default.tum", "default_landmarks.csv", "truth.tum",
                           "landmarks_truth.csv", "summary.json"}) {
    const std::string bytes = slurp(folder / "a" / file);
    EXPECT_FALSE(bytes.empty()) << file;
    EXPECT_EQ(bytes, slurp(folder / "b" / file)) << file;
  }
  const Json summary = Json::parse(slurp(folder / "a" / "summary.json"));
  EXPECT_EQ(lines_of(slurp(folder / "a" / "default.csv")),
            summary["filters"][0]["frames"].get<std::size_t>() + 1);
  EXPECT_EQ(lines_of(slurp(folder / "a" / "default_landmarks.csv")),
            summary["filters"][0]["landmarks"].get<std::size_t>() + 1);
  EXPECT_TRUE(Json::parse(slurp(folder / "a" / "timing.json")).contains("default"));
}

TEST(Compare, HasTheSameFiguresForASceneAndItsRecording) {
  const Scratch folder;
  const Outcome made =
      chasles(folder, "simulate turntable --set revolutions=0.15 --run 2 -o rec --json");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_GT(Json::parse(made.out).at("imu_samples").get<int>(), 200);
  const Outcome scene = chasles(folder, "compare " + kScene + "--run 2 --preset default --json");
  const Outcome recording = chasles(folder, "compare rec --run 2 --preset default --json");
  ASSERT_EQ(scene.code, 0) << scene.err;
  ASSERT_EQ(recording.code, 0) << recording.err;
  const Json a = Json::parse(scene.out)["filters"][0], b = Json::parse(recording.out)["filters"][0];
  for (const char* name : {"position_error_m", "attitude_error_deg", "nees_pose", "nis_per_dof"}) {
    EXPECT_NEAR(a.at(name).get<double>(), b.at(name).get<double>(), 1e-6) << name;
  }
}

TEST(Compare, GoesAlongAGivenTrajectory) {
  const Scratch folder;
  std::string tum;
  for (int i = 0; i <= 80; ++i) {
    const double t = 0.05 * i;
    tum += std::to_string(t) + " " + std::to_string(std::cos(t)) + " " +
           std::to_string(std::sin(t)) + " 0 0 0 " + std::to_string(std::sin(t / 2)) + " " +
           std::to_string(std::cos(t / 2)) + "\n";
  }
  spill(folder / "circle.tum", tum);
  const Outcome outcome =
      chasles(folder, "compare trajectory --path circle.tum --preset default --json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json json = Json::parse(outcome.out);
  EXPECT_NEAR(json["filters"][0]["recorded_seconds"].get<double>(), 4, 0.1);
  EXPECT_LT(json["filters"][0]["position_error_m"].get<double>(), 0.3);
}

TEST(Compare, DrivesInLoopsWithTheFourCharts) {
  const Scratch folder;
  const Outcome outcome = chasles(folder, "compare loops --run 3 --scene-set sigma=0.02 -o a");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_part(outcome.out, "loops: 501 frames, seed 1, run 3");
  const Json summary = Json::parse(slurp(folder / "a" / "summary.json"));
  ASSERT_EQ(summary.at("filters").size(), 4u);
  EXPECT_EQ(summary["filters"][3]["filter"], "right-sen3");
  EXPECT_EQ(summary["scene"]["sigma"], 0.02);
  EXPECT_GT(summary["filters"][0]["ate_first_pose_m"].get<double>(), 0);
  EXPECT_EQ(read_tum(folder / "a" / "truth.tum").size(), 501u);
  EXPECT_EQ(read_tum(folder / "a" / "right-sen3.tum").size(), 501u);
  EXPECT_EQ(lines_of(slurp(folder / "a" / "standard.csv")), 502u);
  EXPECT_EQ(lines_of(slurp(folder / "a" / "landmarks_truth.csv")), 301u);
  expect_error(chasles(folder, "compare loops --preset default"), 1, "the scene loops has neither");
  expect_error(chasles(folder, "compare loops --init multi-view"), 1,
               "initialises a landmark at the first observation");
  expect_error(chasles(folder, "compare loops --scene-set range=-1"), 1, "range: found '-1'");
}

// `chasles report` of the studies of compare and montecarlo.
TEST(ReportOfStudies, IsDistinguishedFromThatOfRunsByContent) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder, "compare " + kScene + "--preset paper -o one --quiet").code, 0);
  ASSERT_EQ(chasles(folder,
                    "montecarlo loops --scene-set steps=60 --scene-set loops=1 --runs 3 -o runs "
                    "--quiet")
                .code,
            0);
  const Outcome made = chasles(folder, "report one runs -o pages/study.html");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_EQ(made.out, "page: pages/study.html\n");
  const std::string page = slurp(folder / "pages" / "study.html");
  for (const char* part : {"More on consistency and errors", "paper-right-se3", "\"turntable\"",
                           "right-sen3", "\"loops\"", "\"chi2_3_high\""}) {
    expect_part(page, part);
  }
  ASSERT_EQ(chasles(folder, "report one runs -o again.html").code, 0);
  EXPECT_EQ(page, slurp(folder / "again.html"));
}

TEST(ReportOfStudies, SaysWhatIsWrong) {
  const Scratch folder;
  const std::string study =
      "montecarlo loops --scene-set steps=60 --scene-set loops=1 --runs 2 --quiet -o a";
  ASSERT_EQ(chasles(folder, study).code, 0);
  const auto rejected = [&](const char* part) {
    expect_error(chasles(folder, "report a -o x.html"), 2, part);
    EXPECT_FALSE(std::filesystem::exists(folder / "x.html")) << part;
  };
  const std::string trials = slurp(folder / "a" / "trials.jsonl");
  spill(folder / "a" / "trials.jsonl", trials.substr(0, trials.size() / 2));
  rejected("trials.jsonl");
  spill(folder / "a" / "trials.jsonl", trials);
  std::filesystem::remove(folder / "a" / "curves.csv");
  rejected("curves.csv");
  std::filesystem::remove(folder / "a" / "summary.json");
  rejected("the study is not complete");
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec -o run --quiet").code, 0);
  expect_error(chasles(folder, "report a run -o x.html"), 1, "a page shows runs or studies");
  expect_error(chasles(folder, "report run a -o x.html"), 1, "a page shows runs or studies");
  expect_error(chasles(folder, "report none -o x.html"), 2, "none");
}

TEST(Compare, RejectsWhatItDoesNotKnow) {
  const Scratch folder;
  expect_error(chasles(folder, "compare halway"), 1, "neither a scene nor a recording");
  expect_error(chasles(folder, "compare trajectory"), 1, "--path FILE");
  expect_error(chasles(folder, "compare hallway --path x"), 1, "for the scene trajectory");
  expect_error(chasles(folder, "compare trajectory --path none.tum"), 2, "none.tum");
  expect_error(chasles(folder, "compare hallway --charts left"), 1,
               "--charts: chart: found 'left'");
  expect_error(chasles(folder, "compare hallway --init never"), 1, "--init: found 'never'");
  expect_error(chasles(folder, "compare hallway --landmarks a"), 1, "--landmarks: found 'a'");
  expect_error(chasles(folder, "compare hallway --preset best"), 1, "--preset: found 'best'");
  expect_error(chasles(folder, "compare hallway --preset paper,paper"), 1, "is there twice");
  for (const char* name : {"a,b.yaml", "truth.yaml"}) {
    spill(folder / name, "gate: 0.9\n");
    expect_error(chasles(folder, "compare hallway --config '" + std::string(name) + "'"), 1,
                 "found a filter called");
  }
  expect_error(chasles(folder, "compare hallway --set gat=1"), 1, "did you mean 'gate'?");
  expect_error(chasles(folder, "compare hallway --set gate=2"), 1, "--set: gate: found '2'");
  expect_error(chasles(folder, "compare hallway --set chart=standard"), 1, "expected --charts");
  expect_error(chasles(folder, "compare hallway --scene-set sectons=1"), 1,
               "--scene-set: unknown key 'sectons'; did you mean 'sections'?");
  expect_error(chasles(folder, "compare hallway --scene-set sections=0"), 1, "sections: found '0'");
  expect_error(chasles(folder, "compare hallway --scene-set geometry=turntable"), 1, "geometry");
  expect_error(chasles(folder, "compare hallway --seed x"), 1, "--seed: found 'x'");
  simulate(folder);
  expect_error(chasles(folder, "compare rec"), 2, "has no camera");
  expect_error(chasles(folder, "compare rec --scene-set sections=1"), 1, "for scenes");
}

// Real samples contain the full motion, so the simulated camera must follow it as well.
TEST(Simulate, FollowsAQuickTruthThatComesWithItsSamples) {
  const Scratch folder;
  std::string shaken = "# time x y z qx qy qz qw\n";
  for (int k = 0; k < 1000; ++k) {
    const double t = 0.01 * k;
    shaken +=
        fmt::format("{:.2f} {:.6f} {:.6f} 0 0 0 0 1\n", 100 + t, 0.3 * t, 0.01 * std::sin(25 * t));
  }
  spill(folder / "shaken.tum", shaken);
  const auto simulated = [&](const std::string& options) {
    EXPECT_EQ(chasles(folder, "simulate trajectory --quiet --set frame_rate=50 " + options).code,
              0);
  };
  const auto error = [&](const std::string& recording) {
    const Outcome outcome =
        chasles(folder, "evaluate " + recording + "/truth.tum shaken.tum --json");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out).at("ate_m").get<double>();
  };
  simulated("--path shaken.tum --set knot_interval=0.02 -o fine");
  simulated("--path fine --real-imu -o with_samples");
  simulated("--path fine -o without");
  EXPECT_LT(error("with_samples"), 2e-4);
  EXPECT_GT(error("without"), 1e-3);
}

TEST(Simulate, KnowsTheScenesOfBothKinds) {
  const Scratch folder;
  expect_error(chasles(folder, "simulate halway -o x"), 1,
               "unknown scene 'halway'; did you mean 'hallway'? (known scenes: street");
  expect_error(chasles(folder, "simulate street --path x -o x"), 1, "for the scene trajectory");
  expect_error(chasles(folder, "simulate hallway --agreed-truth -o x"), 1,
               "--agreed-truth are for the scene trajectory, not for hallway");
  expect_error(chasles(folder, "simulate trajectory --path x --agreed-truth -o x"), 1,
               "needs --real-imu");
  expect_error(chasles(folder, "simulate street --run 1 -o x"), 1, "--run");
  expect_error(chasles(folder, "simulate hallway --set route=L -o x"), 1, "unknown key 'route'");
  const Outcome help = chasles(folder, "simulate --help");
  for (const char* part : {"hallway", "turntable", "trajectory", "gyroscope_random_walk"}) {
    expect_part(help.out, part);
  }
}

}  // namespace
}  // namespace chasles::test
