#include <functional>

#include <nlohmann/json.hpp>

#include <chasles/lie/so3.hpp>
#include <chasles/lie/trajectory.hpp>
#include <chasles/recording/readers.hpp>

#include "cli_test.hpp"

// --truth-errors of `evaluate` and `run`, and what `check` measures of a truth by the IMU alone.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

class CliTruthErrors : public ::testing::Test {
 protected:
  void SetUp() override {
    const Outcome made =
        chasles(folder, "simulate walk -o rec --quiet --set walk_duration=20 && '" +
                            std::string(CHASLES_BINARY) + "' run rec -o out --quiet");
    ASSERT_EQ(made.code, 0) << made.err;
    // The file's position at t is that of 12 ms before, and its attitudes are turned by 1.5 deg.
    const Trajectory truth = read_tum(folder / "rec/truth.tum");
    Trajectory wrong;
    for (const StampedPose& row : truth) {
      const auto before = pose_at(truth, row.time - from_seconds(0.012));
      if (!before) continue;
      wrong.push_back({row.time, {so3::exp({0, 0, -0.026}) * row.pose.R, before->p}});
    }
    write_tum(wrong, folder / "wrong.tum");
  }

  Json of(const std::string& command) {
    const Outcome outcome = chasles(folder, command + " --json");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.code == 0 ? Json::parse(outcome.out) : Json();
  }

  static void expect_near(const Json& constant, double expected) {
    EXPECT_NEAR(constant.at("value").get<double>(), expected,
                4 * constant.at("sigma").get<double>());
    EXPECT_TRUE(constant.at("significant").get<bool>());
  }

  Scratch folder;
};

TEST_F(CliTruthErrors, OfAWrongTruthAreRemovedFromTheFigures) {
  const Json right = of("evaluate out"), plain = of("evaluate out wrong.tum");
  EXPECT_FALSE(plain.contains("truth_errors"));
  Json with = of("evaluate out wrong.tum --truth-errors auto");
  const Json errors = with.at("truth_errors");
  expect_near(errors.at("position_time_s"), 0.012);
  expect_near(errors.at("first_heading_deg"), 1.49);
  EXPECT_GT(plain.at("nees_pose").get<double>(), 2 * right.at("nees_pose").get<double>());
  EXPECT_LT(errors.at("nees_pose").at("mean").get<double>(),
            0.5 * plain.at("nees_pose").get<double>());
  EXPECT_LT(errors.at("ate_m").get<double>(), 1.2 * right.at("ate_m").get<double>());
  with.erase("truth_errors");
  EXPECT_EQ(with, plain) << "the other figures stay";
  const Outcome text = chasles(folder, "evaluate out wrong.tum --truth-errors auto");
  expect_part(text.out, "time of the positions, ms");
  expect_part(text.out, "without errors of the truth");
  expect_part(chasles(folder, "evaluate out wrong.tum --truth-errors auto --markdown").out,
              "| constant of the truth");
}

TEST_F(CliTruthErrors, OfARunAreThoseOfEvaluate) {
  const Json summary = of("run rec --quiet --truth wrong.tum --truth-errors auto -o other");
  const Json errors = of("evaluate other --truth-errors auto").at("truth_errors");
  const double expected = errors.at("nees_pose").at("mean");
  EXPECT_NEAR(summary.at("truth_errors").at("nees_pose").at("mean").get<double>(), expected,
              1e-3 * expected);
  EXPECT_FALSE(of("run rec --quiet").contains("truth_errors"));
  expect_part(chasles(folder, "run rec --quiet --truth wrong.tum --truth-errors auto").out,
              "errors of truth removed");
}

TEST_F(CliTruthErrors, AreAutoOrNoneAndNeedARunWithATruth) {
  expect_error(chasles(folder, "evaluate out --truth-errors yes"), 1,
               "--truth-errors: found 'yes', expected auto or none");
  expect_error(chasles(folder, "run rec --truth-errors 1"), 1, "expected auto or none");
  EXPECT_FALSE(of("evaluate out --truth-errors none").contains("truth_errors"));
  expect_error(chasles(folder, "evaluate out/trajectory.tum rec --truth-errors auto"), 1,
               "out/trajectory.tum is a trajectory without covariances, expected a run folder");
  Trajectory positions = read_tum(folder / "rec/truth.tum");
  for (StampedPose& row : positions) row.pose.R.setIdentity();
  write_tum(positions, folder / "positions.tum");
  expect_error(chasles(folder, "evaluate out positions.tum --truth-errors auto"), 1,
               "positions alone, expected poses with attitudes");
  for (const char* file : {"rec/truth.tum", "rec/true_motion.csv"}) {
    std::filesystem::remove(folder / file);
  }
  expect_error(chasles(folder, "run rec --truth-errors auto"), 1, "give one with --truth");
}

TEST_F(CliTruthErrors, AreNoCureOfATruthThatIsAnotherThing) {
  Trajectory late = read_tum(folder / "rec/truth.tum");
  for (StampedPose& row : late) row.time += std::chrono::seconds(1);
  write_tum(late, folder / "late.tum");
  const std::string mend = "what is named of the truth is none of them; mend it first";
  expect_part(chasles(folder, "evaluate out late.tum --truth-errors auto").err, mend);
  expect_part(chasles(folder, "run rec --quiet --truth late.tum --truth-errors auto").out, mend);
  EXPECT_EQ(chasles(folder, "evaluate out --truth-errors auto").err, "");
}

TEST_F(CliTruthErrors, CheckMeasuresTimesAndHeadingByTheImuAlone) {
  const Json right = of("check rec").at("facts").at("truth");
  EXPECT_NEAR(right.at("positions late").at("value").get<double>(), 0,
              5 * right.at("sigma of positions late").at("value").get<double>() + 0.5);
  const Json wrong = of("check rec --truth wrong.tum");
  const Json facts = wrong.at("facts").at("truth");
  EXPECT_NEAR(facts.at("positions late").at("value").get<double>(), 12, 2);
  EXPECT_NEAR(facts.at("attitudes late").at("value").get<double>(), 0, 1);
  EXPECT_NEAR(facts.at("heading against its positions").at("value").get<double>(), 1.49, 0.5);
  expect_part(wrong.at("findings").dump(), "ms later than its attitudes, by the IMU alone");
}

}  // namespace
}  // namespace chasles::test
