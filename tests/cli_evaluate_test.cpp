#include <Eigen/Geometry>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/recording/readers.hpp>

#include "cli_test.hpp"

// `chasles evaluate`: which argument is the truth, and how it is paired.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

Json evaluated(const Outcome& outcome) {
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return outcome.code == 0 ? Json::parse(outcome.out) : Json();
}

TEST(Evaluate, WarnsOfATrajectoryThatIsComparedWithItself) {
  const Scratch folder;
  simulate(folder);
  const Outcome same = chasles(folder, "evaluate rec/truth.tum rec --json");
  EXPECT_LT(evaluated(same).at("ate_m").get<double>(), 1e-6);
  EXPECT_TRUE(evaluated(same).at("nees_pose").is_null());
  expect_part(same.err, "is it the same trajectory twice?");
}

TEST(Evaluate, OfARunFolderAgreesWithItsSummary) {
  const Scratch folder;
  simulate(folder);
  const Json run = evaluated(chasles(folder, "run rec --json --quiet -o out"));
  for (const char* truth : {"", " rec", " rec/truth.tum"}) {
    const Outcome outcome = chasles(folder, std::string("evaluate out --json") + truth);
    EXPECT_EQ(outcome.err, "");
    const Json figures = evaluated(outcome);
    for (const char* name : {"ate_m", "attitude_deg", "nees_pose", "coverage"}) {
      const double expected = run.at(name).get<double>();
      EXPECT_NEAR(figures.at(name).get<double>(), expected, 1e-6 * expected) << name << truth;
    }
  }
  expect_part(chasles(folder, "evaluate out").out, "alignment");
  expect_part(chasles(folder, "evaluate out --markdown").out, "| alignment");
}

TEST(Evaluate, TheSmoothedPathHasTheFiguresOfTheSummary) {
  const Scratch folder;
  simulate_turntable(folder);
  const Json run = evaluated(chasles(folder, "run rec --json --quiet -o out"));
  const Json figures = evaluated(chasles(folder, "evaluate out --smoothed --json"));
  for (const char* name : {"ate_m", "attitude_deg", "nees_pose", "within_3_sigma_x"}) {
    const double expected = run.at("smoothed").at(name).get<double>();
    EXPECT_NEAR(figures.at(name).get<double>(), expected, 1e-6 * expected) << name;
  }
  EXPECT_NE(figures.at("nees_pose"), run.at("nees_pose"));
  expect_error(chasles(folder, "evaluate out/trajectory.tum out/truth.tum --smoothed"), 1,
               "--smoothed: out/trajectory.tum is a file, expected a run folder");
  ASSERT_EQ(chasles(folder, "run rec --estimator batch --quiet -o batch").code, 0);
  expect_error(chasles(folder, "evaluate batch --smoothed"), 1, "batch has no smoothed.csv");
}

// evo has the truth first. The truth of the run folder would then be compared with itself.
TEST(Evaluate, ARunFolderIsNoTruth) {
  const Scratch folder;
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec --quiet -o out").code, 0);
  ASSERT_EQ(chasles(folder, "run rec --quiet -o other --chart standard").code, 0);
  expect_error(chasles(folder, "evaluate rec/truth.tum out"), 1,
               "out is a run folder, which holds an estimate; expected the truth second: `chasles "
               "evaluate out rec/truth.tum`");
  expect_error(chasles(folder, "evaluate rec out"), 1, "`chasles evaluate out rec`");
  expect_error(chasles(folder, "evaluate other out"), 1, "out/trajectory.tum to compare two");
  expect_error(chasles(folder, "evaluate out out"), 1, "out is a run folder");
  EXPECT_EQ(chasles(folder, "evaluate other out/trajectory.tum").code, 0);
  const Outcome itself = chasles(folder, "evaluate out out/trajectory.tum");
  EXPECT_EQ(itself.code, 0);
  expect_part(itself.err, "is it the same trajectory twice?");
}

TEST(Evaluate, ATruthBetweenTheFramesIsInterpolated) {
  const Scratch folder;
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec --quiet -o out").code, 0);
  // The truth 40 ms after its stamps, which are 0.1 s apart, at some 5 m/s: nearest is 0.2 m off.
  Trajectory truth = read_tum(folder / "rec/truth.tum"), between;
  for (std::size_t i = 0; i + 1 < truth.size(); ++i) {
    const Time time = truth[i].time + 2 * (truth[i + 1].time - truth[i].time) / 5;
    between.push_back({time, *pose_at(truth, time)});
  }
  write_tum(between, folder / "between.tum");
  const auto figure = [&](const std::string& more, const char* name) {
    return evaluated(chasles(folder, "evaluate out --json " + more)).at(name).get<double>();
  };
  const double exact = figure("", "ate_first_pose_m");
  EXPECT_NEAR(figure("between.tum", "ate_first_pose_m"), exact, 0.05);
  EXPECT_GT(figure("between.tum --pairing nearest", "ate_first_pose_m"), exact + 0.1);
  EXPECT_EQ(figure("--pairing nearest", "ate_first_pose_m"), exact);
  expect_part(chasles(folder, "evaluate out between.tum").out, "interpolated at ");
  expect_error(chasles(folder, "evaluate out between.tum --max-truth-gap 0.01"), 2,
               "a longer gap (--max-truth-gap) or the nearest stamps (--pairing nearest)");
  expect_error(chasles(folder, "evaluate out --pairing best"), 1,
               "--pairing: found 'best', expected interpolate or nearest");
  expect_error(chasles(folder, "evaluate out --max-truth-gap -1"), 1, "--max-truth-gap");
}

TEST(Evaluate, TakesThePairingOfTheRun) {
  const Scratch folder;
  simulate(folder);
  const Json run = evaluated(
      chasles(folder, "run rec --json --quiet -o out --pairing nearest --max-truth-gap 0.25"));
  EXPECT_EQ(run.at("pairing"), "nearest");
  EXPECT_EQ(run.at("max_truth_gap"), 0.25);
  spill(folder / "out/summary.json",
        slurp(folder / "out/summary.json")
            .replace(slurp(folder / "out/summary.json").find("\"nearest\""), 9, "\"farthest\""));
  expect_error(chasles(folder, "evaluate out"), 2,
               "summary.json: pairing: expected interpolate or nearest");
}

// The same poses in the forms that other programs write.
TEST(Evaluate, ReadsTruthsInTheirUsualForms) {
  const Scratch folder;
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec --quiet -o out").code, 0);
  const Trajectory truth = read_tum(folder / "rec/truth.tum");
  std::string states =
      "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], "
      "q_RS_x [], q_RS_y [], q_RS_z []\r\n";
  for (const StampedPose& row : truth) {
    const Eigen::Quaterniond q(row.pose.R);
    states += fmt::format("{},{},{},{},{},{},{},{}\r\n", row.time.count(), row.pose.p.x(),
                          row.pose.p.y(), row.pose.p.z(), q.w(), q.x(), q.y(), q.z());
  }
  spill(folder / "data.csv", states);
  const double expected = evaluated(chasles(folder, "evaluate out --json")).at("ate_m");
  const Json figures = evaluated(chasles(folder, "evaluate out data.csv --json"));
  EXPECT_NEAR(figures.at("ate_m").get<double>(), expected, 1e-9);
  spill(folder / "kitti.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  expect_error(chasles(folder, "evaluate out kitti.txt"), 2, "as in KITTI's pose files?");
}

}  // namespace
}  // namespace chasles::test
