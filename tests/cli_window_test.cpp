#include <filesystem>

#include <nlohmann/json.hpp>

#include <chasles/recording/readers.hpp>
#include <chasles/run_folder/run.hpp>

#include "cli_process.hpp"

// Results of `chasles run --estimator window:N`.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

TEST(RunWindow, WithBodyVelocitiesWritesTheFilesOfARun) {
  const Scratch folder;
  simulate(folder);
  const std::string command = "run rec --json --quiet --estimator ";
  const Outcome one = chasles(folder, command + "window:8 -o one");
  ASSERT_EQ(one.code, 0) << one.err;
  ASSERT_EQ(chasles(folder, command + "window:8 -o two").code, 0);
  expect_same_runs(folder, "one", "two");
  const Json window = Json::parse(one.out);
  const Json filter = Json::parse(chasles(folder, command + "filter").out);
  EXPECT_FALSE(filter.contains("window"));
  EXPECT_EQ(window.at("frames"), filter.at("frames"));
  EXPECT_EQ(window.at("window").at("window"), 8);
  EXPECT_EQ(window.at("window").at("keyframes"), window.at("frames"));
  EXPECT_EQ(window.at("settings").at("batch.loss"), "huber");
  EXPECT_EQ(window.at("health"), "ok");
  EXPECT_TRUE(window.at("nees_pose").is_number());
  EXPECT_TRUE(window.at("window_seconds").is_number());
  EXPECT_GT(read_run(folder / "one").landmarks.size(), 10u);
}

TEST(RunWindow, WithAnImuTheSame) {
  const Scratch folder;
  simulate_turntable(folder);
  const std::string command = "run rec --begin truth --json --quiet --estimator window:5 ";
  const Outcome one = chasles(folder, command + "-o one");
  ASSERT_EQ(one.code, 0) << one.err;
  ASSERT_EQ(chasles(folder, command + "-o two").code, 0);
  expect_same_runs(folder, "one", "two");
  const Json window = Json::parse(one.out);
  EXPECT_EQ(window.at("window").at("window"), 5);
  EXPECT_EQ(window.at("window").at("keyframes"), read_run(folder / "one").states.size());
  EXPECT_LT(window.at("ate_posyaw_m").get<double>(), 0.2);
  EXPECT_EQ(chasles(folder, command + "--realtime").code, 1);
}

// The live run shows the estimates of the window, not those of a filter.
TEST(RunWindow, WithAnImuIsThereWhileItGoes) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder, "simulate hallway -o rec --quiet").code, 0);
  const std::string out = (folder / "out").string();
  Process run(folder, {"run", (folder / "rec").string(), "--begin", "truth", "--estimator",
                       "window:12", "-o", out});
  for (int tries = 0; tries < 10000 && !std::filesystem::exists(out + "/growing/summary.json");
       ++tries) {
    ::usleep(2000);
  }
  EXPECT_EQ(run.code_after(SIGINT), 130) << run.output();
  const Json summary = Json::parse(slurp(out + "/summary.json"));
  EXPECT_NE(summary.at("remarks").dump().find("interrupted after "), std::string::npos);
  const chasles::Run kept = read_run(out);
  EXPECT_GT(kept.states.size(), 20u);
  EXPECT_LT(kept.states.size(), read_recording(folder / "rec").frames.size());
  EXPECT_EQ(summary.at("window").at("keyframes"), kept.states.size());
  EXPECT_TRUE(summary.at("nis_per_dof").is_null());
}

TEST(RunWindow, RejectsWhatIsNoWindow) {
  const Scratch folder;
  simulate(folder);
  for (const char* estimator : {"window:1", "window:0", "window:-4", "window:", "window",
                                "window:many", "window:8.5", "window:99999999999999999999"}) {
    const Outcome outcome =
        chasles(folder, std::string("run rec --quiet --estimator ") + estimator);
    EXPECT_EQ(outcome.code, 1) << estimator;
    EXPECT_NE(outcome.err.find("window:N with N of 2 or more"), std::string::npos) << outcome.err;
  }
  const auto rejected = [&](const std::string& more, const std::string& words) {
    const Outcome outcome = chasles(folder, "run rec --quiet --estimator window:8 " + more);
    EXPECT_EQ(outcome.code, 1) << more;
    EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
  };
  rejected("--mode localize", "--mode slam");
  rejected("--full-covariance P.npy", "--full-covariance");
  rejected("--set batch.loss=square", "huber");
  rejected("--set batch.window_steps=0", "batch.window_steps");
}

TEST(CompareWindow, StandsBesideItsFilter) {
  const Scratch folder;
  const std::string command =
      "compare turntable --scene-set revolutions=0.3 --charts right-sen3 --json --quiet "
      "--estimators ";
  const Outcome outcome =
      chasles(folder, command + "filter,window:5 --set batch.loss=none -o study");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json filters = Json::parse(outcome.out).at("filters");
  ASSERT_EQ(filters.size(), 2u);
  EXPECT_EQ(filters[1].at("estimator"), "window:5");
  EXPECT_EQ(filters[1].at("filter").get<std::string>(),
            filters[0].at("filter").get<std::string>() + "+window5");
  EXPECT_EQ(filters[1].at("settings").at("batch.loss"), "none");
  EXPECT_EQ(chasles(folder, command + "window:1").code, 1);
  EXPECT_EQ(chasles(folder, "compare loops --estimators window:5").code, 1);
}

}  // namespace
}  // namespace chasles::test
