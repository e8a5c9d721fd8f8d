#include <nlohmann/json.hpp>

#include <chasles/run_folder/run.hpp>

#include "cli_test.hpp"

// Results of `chasles run --estimator batch`.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

TEST(RunBatch, WritesTheFilesOfARunTheSameEveryTime) {
  const Scratch folder;
  simulate_turntable(folder);
  const std::string command = "run rec --begin truth --estimator batch --json --quiet -o ";
  const Outcome one = chasles(folder, command + "one");
  ASSERT_EQ(one.code, 0) << one.err;
  ASSERT_EQ(chasles(folder, command + "two").code, 0);
  expect_same_runs(folder, "one", "two");
  const chasles::Run run = read_run(folder / "one");
  const Json summary = Json::parse(slurp(folder / "one/summary.json"));
  const Json& batch = summary.at("batch");
  EXPECT_TRUE(batch.at("converged").get<bool>());
  EXPECT_EQ(batch.at("keyframes"), run.states.size());
  EXPECT_EQ(batch.at("landmarks"), run.landmarks.size());
  EXPECT_GT(batch.at("iterations"), 2);
  EXPECT_LT(batch.at("final_cost").get<double>(), batch.at("initial_cost").get<double>());
  EXPECT_EQ(summary.at("settings").at("batch.loss"), "huber");
  EXPECT_EQ(summary.at("health"), "ok");
  EXPECT_TRUE(summary.at("nees_pose").is_number());
  EXPECT_TRUE(summary.at("nis_per_dof").is_null());

  const Outcome filter = chasles(folder, "run rec --begin truth --json --quiet");
  ASSERT_EQ(filter.code, 0) << filter.err;
  EXPECT_LT(summary.at("ate_posyaw_m").get<double>(),
            Json::parse(filter.out).at("ate_posyaw_m").get<double>());
}

TEST(RunBatch, AndAWindowStateTheFactorOfTheirCovariances) {
  const Scratch folder;
  simulate_turntable(folder);
  for (const std::string estimator : {"batch", "window:5"}) {
    const std::string key = estimator.substr(0, estimator.find(':'));
    const auto run_with = [&](const std::string& factor) {
      const Outcome run =
          chasles(folder, "run rec --begin truth --json --quiet --estimator " + estimator +
                              " --set batch.covariance_factor=" + factor + " -o " + key + factor);
      EXPECT_EQ(run.code, 0) << run.err;
      return Json::parse(run.out);
    };
    const Json one = run_with("1"), four = run_with("4"), half = run_with("0.5");
    EXPECT_EQ(one.at("remarks").dump().find("covariance_factor"), std::string::npos);
    EXPECT_NE(four.at("remarks").dump().find("batch.covariance_factor"), std::string::npos);
    EXPECT_EQ(four.at(key).at("covariance_factor"), 4);
    EXPECT_EQ(half.at(key).at("covariance_factor"), 0.5);
    EXPECT_EQ(four.at("ate_m"), one.at("ate_m"));
    const chasles::Run narrow = read_run(folder / (key + "1")),
                       wide = read_run(folder / (key + "4"));
    ASSERT_EQ(narrow.states.size(), wide.states.size());
    EXPECT_TRUE(wide.states.back().pose_covariance.isApprox(
        4 * narrow.states.back().pose_covariance, 1e-6));
  }
  const Outcome wrong =
      chasles(folder, "run rec --estimator batch --quiet --set batch.covariance_factor=0");
  EXPECT_EQ(wrong.code, 1);
  EXPECT_NE(wrong.err.find("batch.covariance_factor"), std::string::npos) << wrong.err;
}

TEST(RunBatch, TakesItsSettingsAndRejectsOthers) {
  const Scratch folder;
  simulate_turntable(folder);
  const std::string command = "run rec --begin truth --estimator batch --json --quiet ";
  const Outcome few = chasles(
      folder, command + "--set batch.frames_per_keyframe=5 --set batch.landmarks=cartesian");
  ASSERT_EQ(few.code, 0) << few.err;
  const Json summary = Json::parse(few.out);
  EXPECT_LT(summary.at("frames").get<int>(), 50);
  EXPECT_EQ(summary.at("settings").at("batch.landmarks"), "cartesian");

  const auto rejected = [&](const std::string& more, const std::string& words) {
    const Outcome outcome = chasles(folder, command + more);
    EXPECT_EQ(outcome.code, 1) << more;
    EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
  };
  rejected("--set batch.loss=square", "huber");
  rejected("--set batch.max_iterations=0", "batch.max_iterations");
  rejected("--realtime", "--realtime");
  const Outcome unknown = chasles(folder, "run rec --estimator swarm");
  EXPECT_EQ(unknown.code, 1);
  EXPECT_NE(unknown.err.find("filter, batch or window:N"), std::string::npos);
}

TEST(RunBatch, ARunThatHasNotConvergedSaysSo) {
  const Scratch folder;
  simulate_turntable(folder);
  const Outcome outcome = chasles(
      folder,
      "run rec --begin truth --estimator batch --json --quiet --set batch.max_iterations=2");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json summary = Json::parse(outcome.out);
  EXPECT_EQ(summary.at("health"), "degraded");
  EXPECT_NE(summary.at("remarks").dump().find("did not converge within 2 steps"),
            std::string::npos);
}

// Any landmark coordinates and a poor initial estimate lead to the same minimum.
TEST(RunBatch, BeginsAsBadlyAsStated) {
  const Scratch folder;
  simulate_turntable(folder);
  const auto batch = [&](const std::string& more) {
    const Outcome outcome = chasles(
        folder,
        "run rec --begin truth --estimator batch --json --quiet --set batch.gate=0 " + more);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return Json::parse(outcome.out).at("batch");
  };
  const Json near = batch("");
  const Json far = batch("--set batch.initial_error=0.1 --set batch.chart=left-se3");
  const Json other = batch("--set batch.initial_error=0.1 --set batch.seed=2");
  EXPECT_GT(far.at("initial_cost"), 1.5 * near.at("initial_cost").get<double>());
  EXPECT_NE(far.at("initial_cost"), other.at("initial_cost"));
  for (const Json& one : {far, other}) {
    EXPECT_NEAR(one.at("final_cost").get<double>() / near.at("final_cost").get<double>(), 1, 1e-5);
    EXPECT_EQ(one.at("stalled"), false);
  }
  const std::string command = "run rec --estimator batch --quiet --set ";
  EXPECT_EQ(chasles(folder, command + "batch.initial_error=-1").code, 1);
  EXPECT_EQ(chasles(folder, command + "batch.chart=polar").code, 1);
}

// With a tolerance of the whole cost the search ends at its initial estimate.
TEST(RunBatch, ASearchThatStalledIsNotCalledOk) {
  const Scratch folder;
  simulate_turntable(folder);
  const Outcome outcome = chasles(folder,
                                  "run rec --begin truth --estimator batch --json --quiet "
                                  "--set batch.gate=0 --set batch.tolerance=1");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json summary = Json::parse(outcome.out);
  EXPECT_EQ(summary.at("batch").at("stalled"), true);
  EXPECT_GT(summary.at("batch").at("decrease_left"), 1e-3);
  EXPECT_EQ(summary.at("health"), "degraded");
  EXPECT_NE(summary.at("remarks").dump().find("batch estimation stalled"), std::string::npos);
}

TEST(CompareBatch, StandsBesideItsFilter) {
  const Scratch folder;
  const std::string command =
      "compare turntable --scene-set revolutions=0.3 --charts right-sen3 --json --quiet "
      "--estimators filter,batch ";
  const Outcome outcome = chasles(folder, command + "--set batch.loss=none -o study");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json filters = Json::parse(outcome.out).at("filters");
  ASSERT_EQ(filters.size(), 2u);
  EXPECT_EQ(filters[0].at("estimator"), "filter");
  EXPECT_EQ(filters[0].at("settings").count("batch.loss"), 0u);
  EXPECT_EQ(filters[1].at("estimator"), "batch");
  EXPECT_EQ(filters[1].at("filter").get<std::string>(),
            filters[0].at("filter").get<std::string>() + "+batch");
  EXPECT_EQ(filters[1].at("settings").at("batch.loss"), "none");
  EXPECT_LT(filters[1].at("ate_posyaw_m"), filters[0].at("ate_posyaw_m"));
  EXPECT_EQ(chasles(folder, command + "--set batch.loss=square").code, 1);
  EXPECT_EQ(chasles(folder, "compare turntable --set batch.loss=none").code, 1);
  EXPECT_EQ(chasles(folder, "compare turntable --estimators swarm").code, 1);
  EXPECT_EQ(chasles(folder, "compare loops --estimators batch").code, 1);
}

TEST(MonteCarloBatch, AveragesOverRuns) {
  const Scratch folder;
  const Outcome outcome =
      chasles(folder,
              "montecarlo turntable --runs 2 --workers 1 --scene-set revolutions=0.3 --charts "
              "standard --estimators batch --json --quiet -o study");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json filter = Json::parse(outcome.out).at("filters").at(0);
  EXPECT_EQ(filter.at("runs"), 2);
  EXPECT_EQ(filter.at("diverged"), 0);
  EXPECT_EQ(filter.at("estimator"), "batch");
}

TEST(RunBatch, WithBodyVelocitiesTheSame) {
  const Scratch folder;
  simulate(folder);
  const std::string command = "run rec --json --quiet ";
  const Outcome one = chasles(folder, command + "--estimator batch -o one");
  ASSERT_EQ(one.code, 0) << one.err;
  ASSERT_EQ(chasles(folder, command + "--estimator batch -o two").code, 0);
  expect_same_runs(folder, "one", "two");
  const Json filter = Json::parse(chasles(folder, command).out), batch = Json::parse(one.out);
  EXPECT_FALSE(filter.contains("batch"));
  EXPECT_TRUE(batch.at("batch").at("converged").get<bool>());
  EXPECT_EQ(batch.at("frames"), filter.at("frames"));
  EXPECT_EQ(batch.at("landmarks"), read_run(folder / "one").landmarks.size());
  EXPECT_EQ(batch.at("settings").at("batch.loss"), "huber");
  EXPECT_EQ(batch.at("settings").at("stereo_rows"), "mean");
  EXPECT_TRUE(batch.at("nis_per_dof").is_null());
  EXPECT_TRUE(batch.at("batch_seconds_solve").is_number());
  const auto rejected = [&](const std::string& more, const std::string& words) {
    const Outcome outcome = chasles(folder, command + "--estimator batch " + more);
    EXPECT_EQ(outcome.code, 1) << more;
    EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
  };
  rejected("--mode localize", "--mode slam");
  rejected("--full-covariance P.npy", "--full-covariance");
  rejected("--set batch.loss=square", "huber");
  rejected("--set initial_landmark_sigma=0.1", "initial_landmark_sigma");
}

}  // namespace
}  // namespace chasles::test
