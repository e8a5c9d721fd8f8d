#include <nlohmann/json.hpp>

#include <chasles/base/constants.hpp>
#include <chasles/lie/trajectory.hpp>
#include <chasles/recording/readers.hpp>

#include "cli_test.hpp"

// `--truth-level`: truths whose world is not level.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

Json figures(const Outcome& outcome) {
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return outcome.code == 0 ? Json::parse(outcome.out) : Json();
}

class TruthLevel : public ::testing::Test {
 protected:
  void SetUp() override {
    simulate_turntable(folder);
    truth = read_tum(folder / "rec/truth.tum");
  }
  // Turns and moves the world of the recording's truth; calibration.yaml states still that it is
  // level.
  void lean(double degrees) {
    const SE3 tilt{so3::exp({0, -degrees / kDegrees, 0}), Eigen::Vector3d(1, 2, 3)};
    Recording recording = read_recording(folder / "rec");
    for (StampedPose& row : recording.truth) row.pose = tilt * row.pose;
    for (TrueLandmark& landmark : recording.true_landmarks) {
      landmark.p_world = tilt * landmark.p_world;
    }
    write_folder_recording(recording, folder / "rec");
  }
  void relative_to_first_pose() {
    Trajectory relative = truth;
    for (StampedPose& row : relative) row.pose = truth.front().pose.inverse() * row.pose;
    write_tum(relative, folder / "rec/truth.tum");
  }
  // Replaces the statement of calibration.yaml.
  void state(const std::string& line) {
    std::string text = slurp(folder / "rec/calibration.yaml");
    const std::size_t at = text.find("truth_level:");
    ASSERT_NE(at, std::string::npos) << "a simulated truth is level, and states it";
    text.replace(at, text.find('\n', at) - at, line);
    spill(folder / "rec/calibration.yaml", text);
  }
  Json run(const std::string& more = "") {
    return figures(chasles(folder, "run rec --json --quiet " + more));
  }

  Scratch folder;
  Trajectory truth;
};

TEST_F(TruthLevel, NoRemovesAKnownTilt) {
  const Json level = run();
  EXPECT_TRUE(level.at("truth_tilt_deg").is_null());
  lean(5);
  const Json leaning = run(), turned = run("--truth-level no -o out");
  EXPECT_TRUE(leaning.at("truth_tilt_deg").is_null()) << "it is stated to be level";
  EXPECT_GT(leaning.at("attitude_posyaw_deg").get<double>(), 4);
  // The tilt error of the estimate, which level["attitude_posyaw_deg"] bounds, is in the angle.
  const double own = level.at("attitude_posyaw_deg");
  EXPECT_NEAR(turned.at("truth_tilt_deg").get<double>(), 5, 2 * own);
  EXPECT_LT(turned.at("attitude_posyaw_deg").get<double>(), 1.1 * own);
  const double ate = level.at("ate_posyaw_m");
  EXPECT_NEAR(turned.at("ate_posyaw_m").get<double>(), ate, 0.2 * ate);
  // What does not depend on the tilt stays, the landmarks' errors as well.
  for (const char* name : {"ate_m", "ate_first_pose_m", "landmarks_rmse_m"}) {
    EXPECT_NEAR(turned.at(name).get<double>(), level.at(name).get<double>(), 1e-7) << name;
  }
  // The run folder holds the turned truth, and evaluate finds the run's figures.
  const Json again = figures(chasles(folder, "evaluate out --json"));
  for (const char* name :
       {"truth_tilt_deg", "ate_posyaw_m", "nees_attitude", "within_3_sigma_rx"}) {
    const double expected = turned.at(name);
    EXPECT_NEAR(again.at(name).get<double>(), expected, 1e-6 * expected) << name;
  }
  const Outcome given = chasles(folder, "evaluate out rec --truth-level no --json");
  const double expected = turned.at("truth_tilt_deg");
  EXPECT_NEAR(figures(given).at("truth_tilt_deg").get<double>(), expected, 1e-6);
  expect_part(given.err, "off the vertical of the estimate: removed");
  const Outcome text = chasles(folder, "run rec --quiet --truth-level no");
  expect_part(text.out, "tilt of the truth");
  expect_part(text.out, "poses within 3 sigma");
}

TEST_F(TruthLevel, AutoFollowsTheRecording) {
  const Json level = run();
  const Json stated = run("--truth-level yes");
  for (const char* name : {"truth_tilt_deg", "ate_posyaw_m", "nees_pose", "remarks"}) {
    EXPECT_EQ(stated.at(name), level.at(name)) << name;
  }
  lean(5);
  state("truth_level: false");
  EXPECT_NEAR(run().at("truth_tilt_deg").get<double>(), 5, 1);
  EXPECT_TRUE(run("--truth-level yes").at("truth_tilt_deg").is_null());
  state("");
  EXPECT_TRUE(run().at("truth_tilt_deg").is_null()) << "nothing is known of it";
}

TEST_F(TruthLevel, AutoTakesATruthThatBeginsAtTheIdentityAsNotLevel) {
  const double tilt =
      kDegrees * std::acos(truth.front().pose.R(2, 2));  // of the body at the first pose
  relative_to_first_pose();
  EXPECT_TRUE(run().at("truth_tilt_deg").is_null()) << "calibration.yaml states otherwise";
  state("");
  EXPECT_NEAR(run().at("truth_tilt_deg").get<double>(), tilt, 1);
  EXPECT_NEAR(run("--backwards").at("truth_tilt_deg").get<double>(), tilt, 1);
  expect_error(chasles(folder, "run rec --begin truth --quiet"), 1,
               "the truth of turntable is not level");
  EXPECT_EQ(chasles(folder, "run rec --truth rec/truth.tum --truth-level yes --quiet").code, 0);
}

TEST_F(TruthLevel, BadValuesAreErrors) {
  expect_error(chasles(folder, "run rec --truth-level perhaps"), 1,
               "--truth-level: found 'perhaps', expected auto, yes or no");
  expect_error(chasles(folder, "evaluate rec/truth.tum rec --truth-level 1"), 1,
               "--truth-level: found '1', expected auto, yes or no");
  state("truth_level: maybe");
  expect_error(chasles(folder, "run rec"), 2, "'truth_level': is 'maybe', expected true");
}

TEST(TruthLevelOfOthers, VelocitiesHaveNoVertical) {
  const Scratch folder;
  simulate(folder);
  expect_error(chasles(folder, "run rec --truth-level no --quiet"), 1,
               "--truth-level is for a run with an IMU");
}

}  // namespace
}  // namespace chasles::test
