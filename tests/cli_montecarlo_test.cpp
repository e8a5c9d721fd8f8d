#include <cmath>
#include <map>

#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/session/progress.hpp>

#include "cli_test.hpp"
#include "trial_log.hpp"

// `chasles montecarlo`: the same bytes for one study in any number of parts.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

const std::string kStudy =
    "montecarlo turntable --scene-set revolutions=0.12 --preset default "
    "--charts standard --runs 5 ";
const char* const kFiles[] = {"plan.json", "trials.jsonl", "summary.json", "curves.csv"};

void expect_same(const Scratch& folder, const char* a, const char* b) {
  for (const char* file : kFiles) {
    const std::string bytes = slurp(folder / a / file);
    EXPECT_FALSE(bytes.empty()) << a << "/" << file;
    EXPECT_EQ(bytes, slurp(folder / b / file)) << a << ", " << b << ": " << file;
  }
}

void do_study(const Scratch& folder, const std::string& more) {
  const Outcome outcome = chasles(folder, kStudy + more);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
}

TEST(MonteCarloCommand, PrintsTablesAndWritesTheStudy) {
  const Scratch folder;
  const Outcome outcome = chasles(folder, kStudy + "-o a --workers 2");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  for (const char* part : {"5 runs", "\ndefault ", "\nstandard+inverse-depth+multi-view ",
                           "95 % band", "median pose/dof", "diverged"}) {
    expect_part(outcome.out, part);
  }
  const Json summary = Json::parse(slurp(folder / "a" / "summary.json"));
  EXPECT_EQ(summary.at("runs"), 5);
  ASSERT_EQ(summary.at("filters").size(), 2u);
  const Json& first = summary["filters"][0];
  EXPECT_EQ(first.at("runs"), 5);
  EXPECT_EQ(first.at("diverged"), 0);
  EXPECT_LT(first.at("band")[0].get<double>(), 1);
  EXPECT_GT(first.at("band")[1].get<double>(), 1);
  expect_part(slurp(folder / "a" / "curves.csv"), "\ndefault,1,");
}

TEST(MonteCarloCommand, HasTheSameBytesForAnyNumberOfWorkers) {
  const Scratch folder;
  do_study(folder, "-o one --workers 1");
  do_study(folder, "-o two --workers 2");
  do_study(folder, "-o many --workers 7");
  expect_same(folder, "one", "two");
  expect_same(folder, "one", "many");
}

TEST(MonteCarloCommand, GoesOnWhereItWasKilled) {
  const Scratch folder;
  do_study(folder, "-o whole");
  const std::string trials = slurp(folder / "whole" / "trials.jsonl");
  for (const std::size_t kept : {std::size_t{0}, trials.size() / 3, trials.size() - 1}) {
    std::filesystem::create_directory(folder / "cut");
    spill(folder / "cut" / "plan.json", slurp(folder / "whole" / "plan.json"));
    spill(folder / "cut" / "trials.jsonl", trials.substr(0, kept));
    do_study(folder, "-o cut --resume");
    expect_same(folder, "whole", "cut");
    std::filesystem::remove_all(folder / "cut");
  }
}

TEST(MonteCarloCommand, ResumesWhatIsCompleteOrNotStarted) {
  const Scratch folder;
  do_study(folder, "-o a --resume");
  do_study(folder, "-o b");
  do_study(folder, "-o b --resume");
  expect_same(folder, "a", "b");
}

TEST(MonteCarloCommand, AddsRunsToAStudy) {
  const Scratch folder;
  do_study(folder, "-o a");
  ASSERT_EQ(chasles(folder, kStudy + "--runs 3 -o b").code, 1) << "--runs twice";
  const std::string small =
      "montecarlo turntable --scene-set revolutions=0.12 --preset default "
      "--charts standard --runs 3 -o c";
  ASSERT_EQ(chasles(folder, small).code, 0);
  do_study(folder, "-o c --resume");
  expect_same(folder, "a", "c");
}

TEST(MonteCarloCommand, JoinsShards) {
  const Scratch folder;
  do_study(folder, "-o whole");
  do_study(folder, "-o s1 --shard 1/3");
  do_study(folder, "-o s2 --shard 2/3");
  do_study(folder, "-o s3 --shard 3/3");
  const Outcome merged = chasles(folder, "montecarlo --merge s3 s1 s2 -o merged");
  ASSERT_EQ(merged.code, 0) << merged.err;
  expect_same(folder, "whole", "merged");
  expect_error(chasles(folder, "montecarlo --merge s1 s1 -o x"), 1, "run 0 is in another");
  expect_error(chasles(folder, "montecarlo --merge s1 s2 -o merged"), 1, "holds a study");
  std::filesystem::remove(folder / "s1" / "summary.json");
  expect_error(chasles(folder, "montecarlo --merge s1 s2 -o x"), 2, "not complete");
}

TEST(MonteCarloCommand, RejectsToMixStudies) {
  const Scratch folder;
  do_study(folder, "-o a");
  expect_error(chasles(folder, kStudy + "-o a"), 1, "--resume continues it");
  expect_error(chasles(folder, kStudy + "-o a --resume --set gate=0.9"), 1,
               "they differ at /filters/0/settings/gate");
  expect_error(chasles(folder, kStudy + "-o a --resume --seed 9"), 1, "/scene/seed");
  expect_error(chasles(folder, kStudy + "-o a --resume --first 1"), 1, "holds run 0");
  EXPECT_TRUE(std::filesystem::exists(folder / "a" / "summary.json")) << "a rejection harmed it";
  std::string trials = slurp(folder / "a" / "trials.jsonl");
  spill(folder / "a" / "trials.jsonl", "{\"run\": 0}\n" + trials);
  expect_error(chasles(folder, kStudy + "-o a --resume"), 2, "trials.jsonl:1: not a trial");
}

TEST(MonteCarloCommand, RejectsWhatItDoesNotKnow) {
  const Scratch folder;
  expect_error(chasles(folder, "montecarlo -o x"), 1, "SCENE is required");
  expect_error(chasles(folder, "montecarlo hallway -o x"), 1, "--runs is required");
  expect_error(chasles(folder, "montecarlo street --runs 2 -o x"), 1, "unknown scene 'street'");
  expect_error(chasles(folder, "montecarlo hallway --runs 2"), 1, "--output is required");
  expect_error(chasles(folder, "montecarlo hallway --runs 2 --workers -1 -o x"), 1, "--workers");
  for (const char* shard : {"0/2", "3/2", "1", "1/", "a/b", "1/2x"}) {
    expect_error(chasles(folder, std::string("montecarlo hallway --runs 2 -o x --shard ") + shard),
                 1, "expected I/N");
  }
  expect_error(chasles(folder, "montecarlo hallway --merge a -o x"), 1, "--merge takes folders");
  expect_error(chasles(folder, "montecarlo --merge a -o x"), 2, "plan.json");
}

TEST(MonteCarloCommand, CountsDivergedRunsAndEndsWithFourWhereAllDid) {
  const Scratch folder;
  // A filter that assumes exact pixels and has no gate against outliers.
  const Outcome outcome =
      chasles(folder,
              "montecarlo turntable --scene-set revolutions=0.3 --scene-set outlier_fraction=1 "
              "--preset default --set gate=1 --set pixel_sigma=0.01 --runs 2 -o a");
  EXPECT_EQ(outcome.code, 4) << outcome.out << outcome.err;
  const Json filter = Json::parse(slurp(folder / "a" / "summary.json")).at("filters")[0];
  EXPECT_EQ(filter.at("runs"), 2);
  EXPECT_EQ(filter.at("diverged"), 2);
  EXPECT_TRUE(filter.at("position_error_m").is_null());
}

// A study of the scene without an IMU.
const std::string kLoops = "montecarlo loops --runs 6 --scene-set steps=100 --scene-set loops=2 ";

TEST(LoopsStudy, HasTheFourChartsInTheOrderOfTheirConsistency) {
  const Scratch folder;
  const Outcome outcome =
      chasles(folder, "montecarlo loops --runs 20 --scene-set sigma=0.05 -o a --workers 2");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_part(outcome.out, "loops: 20 runs");
  const Json summary = Json::parse(slurp(folder / "a" / "summary.json"));
  EXPECT_EQ(summary.at("scene").at("sigma"), 0.05);
  ASSERT_EQ(summary.at("filters").size(), 4u);
  std::map<std::string, double> nees;
  for (const Json& filter : summary["filters"]) {
    nees[filter.at("filter")] = filter.at("nees_pose_per_dof").get<double>();
    EXPECT_EQ(filter.at("settings").size(), 2u) << "settings that do not count";
    EXPECT_TRUE(filter.at("nees_state").is_null());
  }
  // Zhang et al. 2017, Table II: with the landmarks in the group consistent, additive not.
  EXPECT_LT(nees.at("right-sen3"), nees.at("standard"));
  EXPECT_LT(nees.at("right-sen3"), nees.at("left-se3"));
  EXPECT_LT(nees.at("right-sen3"), 1.25);
  EXPECT_GT(nees.at("standard"), 1.25);
  expect_part(slurp(folder / "a" / "curves.csv"), "\nright-sen3,500,");
}

TEST(LoopsStudy, HasTheSameBytesHoweverItCameAbout) {
  const Scratch folder;
  for (const char* more : {"-o one --workers 1", "-o many --workers 3", "-o s1 --shard 1/2",
                           "-o s2 --shard 2/2", "-o cut --first 0"}) {
    const Outcome outcome = chasles(folder, kLoops + more);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
  }
  expect_same(folder, "one", "many");
  ASSERT_EQ(chasles(folder, "montecarlo --merge s2 s1 -o merged").code, 0);
  expect_same(folder, "one", "merged");
  const std::string trials = slurp(folder / "cut" / "trials.jsonl");
  spill(folder / "cut" / "trials.jsonl", trials.substr(0, trials.size() / 2));
  ASSERT_EQ(chasles(folder, kLoops + "-o cut --resume").code, 0);
  expect_same(folder, "one", "cut");
  expect_error(chasles(folder, kLoops + "-o cut --resume --scene-set radius=70"), 1,
               "they differ at /scene/radius");
  expect_error(chasles(folder, kLoops + "-o cut --resume --set first_estimates=true"), 1,
               "they differ at /filters/0/settings/first_estimates");
}

TEST(LoopsStudy, RejectsWhatItDoesNotHave) {
  const Scratch folder;
  const auto rejected = [&](const std::string& arguments, const char* part) {
    expect_error(chasles(folder, kLoops + "-o x " + arguments), 1, part);
    EXPECT_FALSE(std::filesystem::exists(folder / "x")) << arguments;
  };
  rejected("--preset paper", "the scene loops has neither");
  rejected("--landmarks cartesian", "initialises a landmark at the first observation");
  rejected("--init multi-view", "initialises a landmark at the first observation");
  rejected("--path x", "for the scene trajectory, not for loops");
  rejected("--real-imu", "for the scene trajectory, not for loops");
  rejected("--charts left", "--charts: chart: found 'left'");
  rejected("--charts standard,standard", "is there twice");
  rejected("--set gate=0.9", "unknown key 'gate' (known keys: chart, first_estimates)");
  rejected("--set chart=standard", "expected --charts");
  rejected("--scene-set sigma=nan", "sigma: found 'nan'");
  rejected("--scene-set sigma=2",
           "sigma: found '2', expected a finite number not below 0 and not above 1");
  rejected("--scene-set loops=500", "at least 4 steps a loop");
  rejected("--scene-set sectons=1", "unknown key 'sectons'");
  rejected("--scene-set sigma", "--scene-set: found 'sigma', expected key=value");
  rejected("--seed x", "--seed: found 'x'");
}

TEST(TrialLine, IsReadBackTheSame) {
  const double nan = std::nan("");
  TrialRecord record{
      .filter = "f", .run = 1u << 31, .diverged = true, .averages = {}, .seconds = {}};
  record.averages = {.position_error = 1.0 / 3,
                     .attitude_error = nan,
                     .position_rms = 1e-300,
                     .nees_position = 0.1 + 0.2,
                     .nees_attitude = 5e300,
                     .nees_pose = nan,
                     .nis_per_dof = 2.0 / 7,
                     .landmarks = 12};
  record.seconds = {{.position_error = nan, .nees_pose = 1e-17}, {.nees_position = 1.0 / 9}};
  EXPECT_EQ(app::to_line(record).find("smoothed"), std::string::npos);
  record.smoothed = {{.position_error = 0.1, .nees_attitude = nan}};
  const std::string line = app::to_line(record);
  EXPECT_EQ(line.find('\n'), line.size() - 1);
  EXPECT_EQ(app::to_line(app::from_line(line, "x")), line);
  const TrialRecord back = app::from_line(line, "x");
  EXPECT_EQ(back.run, record.run);
  EXPECT_TRUE(back.diverged);
  EXPECT_EQ(back.averages.nees_position, record.averages.nees_position);
  EXPECT_TRUE(std::isnan(back.averages.nees_pose));
  ASSERT_EQ(back.seconds.size(), 2u);
  EXPECT_TRUE(std::isnan(back.seconds[0].position_error));
  EXPECT_EQ(back.seconds[1].nees_position, 1.0 / 9);
  ASSERT_EQ(back.smoothed.size(), 1u);
  EXPECT_EQ(back.smoothed[0].position_error, 0.1);
  EXPECT_TRUE(std::isnan(back.smoothed[0].nees_attitude));
  EXPECT_THROW(app::from_line("{}", "x"), InputError);
  EXPECT_THROW(app::from_line("{\"run\":", "x"), InputError);
}

TEST(ProgressOfRuns, ShowsWhatIsLeft) {
  EXPECT_NE(progress_text(25, 100, 500, 10, "runs").find("25/100 runs, 50 x real time, 30.0 s"),
            std::string::npos);
  EXPECT_NE(progress_text(1, 100, 500, 10, "runs").find("16 min left"), std::string::npos);
}

}  // namespace
}  // namespace chasles::test
