#include <functional>

#include <nlohmann/json.hpp>

#include <chasles/lie/so3.hpp>
#include <chasles/lie/trajectory.hpp>
#include <chasles/recording/readers.hpp>

#include "cli_test.hpp"

// Truths that are not what they seem: what `run`, `evaluate` and `check` say, and the options.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

class CliTruth : public ::testing::Test {
 protected:
  void SetUp() override {
    const Outcome made =
        chasles(folder, "simulate walk -o rec --quiet --set walk_duration=10 && '" +
                            std::string(CHASLES_BINARY) + "' run rec -o out --quiet");
    ASSERT_EQ(made.code, 0) << made.err;
    truth = read_tum(folder / "rec/truth.tum");
  }

  // Writes the truth with each row changed.
  void write(const std::string& name, const std::function<void(StampedPose&)>& change) {
    Trajectory changed = truth;
    for (StampedPose& row : changed) change(row);
    write_tum(changed, folder / name);
  }
  Json evaluated(const std::string& more) {
    const Outcome outcome = chasles(folder, "evaluate out " + more + " --json");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.code == 0 ? Json::parse(outcome.out) : Json();
  }
  static std::string finding(const Json& json) {
    return json.contains("truth_findings") ? json["truth_findings"][0]["finding"] : Json("");
  }

  Scratch folder;
  Trajectory truth;
};

TEST_F(CliTruth, ARightTruthHasNoFinding) {
  EXPECT_FALSE(evaluated("rec/truth.tum").contains("truth_findings"));
  const Json summary = Json::parse(slurp(folder / "out/summary.json"));
  EXPECT_FALSE(summary.contains("truth_findings")) << summary["truth_findings"];
}

TEST_F(CliTruth, TheClockIsFoundAndCorrected) {
  const double right = evaluated("rec/truth.tum").at("ate_m");
  for (const Time off : {Time(100'000'000), Time(1'000'000'000'000)}) {
    write("late.tum", [&](StampedPose& row) { row.time += off; });
    const Json corrected = evaluated("late.tum --truth-time-offset auto");
    EXPECT_NEAR(corrected.at("ate_m").get<double>(), right, 0.1 * right);
    EXPECT_EQ(finding(corrected), "");
  }
  write("late.tum", [](StampedPose& row) { row.time += Time(100'000'000); });
  const Json late = evaluated("late.tum");
  EXPECT_EQ(finding(late), "clock");
  EXPECT_GT(late.at("ate_m").get<double>(), 2 * right);
  EXPECT_NEAR(evaluated("late.tum --truth-time-offset -0.1").at("ate_m").get<double>(), right,
              1e-9);
  // run and check say it, too.
  const Outcome run = chasles(folder, "run rec --truth late.tum --quiet --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const Json summary = Json::parse(run.out);
  ASSERT_EQ(finding(summary), "clock");
  const std::string what = summary["truth_findings"][0]["what"];
  EXPECT_NE(summary["remarks"].dump().find(what), std::string::npos);
  const Outcome check = chasles(folder, "check rec --truth late.tum --json");
  EXPECT_NE(check.out.find("s late by the rotations of the gyroscope"), std::string::npos)
      << check.out;
  EXPECT_NE(check.out.find("--truth-time-offset -0.1"), std::string::npos);
  const Outcome wrong = chasles(folder, "evaluate out late.tum --truth-time-offset soon");
  EXPECT_EQ(wrong.code, 1);
  EXPECT_NE(wrong.err.find("found 'soon', expected auto or seconds"), std::string::npos);
}

TEST_F(CliTruth, PositionsAloneHaveNoAttitudeErrors) {
  std::string text;
  for (const StampedPose& row : truth) {
    text += std::to_string(row.time.count()) + " " + std::to_string(row.pose.p.x()) + " " +
            std::to_string(row.pose.p.y()) + " " + std::to_string(row.pose.p.z()) + "\n";
  }
  spill(folder / "positions.txt", "# time_ns x y z\n" + text);
  const Json right = evaluated("rec/truth.tum"), json = evaluated("positions.txt");
  EXPECT_EQ(finding(json), "positions_only");
  EXPECT_EQ(json.at("truth_attitudes"), false);
  EXPECT_TRUE(json.value("truth_tilt_deg", Json()).is_null()) << "it begins at the origin";
  EXPECT_NEAR(json.at("ate_m").get<double>(), right.at("ate_m").get<double>(), 1e-5);
  EXPECT_FALSE(json.at("nees_position").is_null());
  for (const char* name : {"attitude_deg", "nees_pose", "nees_attitude", "rpe_1s_m",
                           "ate_first_pose_m", "within_3_sigma_rx"}) {
    EXPECT_TRUE(json.at(name).is_null()) << name;
  }
  const Outcome run = chasles(folder, "run rec --truth positions.txt --quiet -o positions");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_FALSE(evaluated("").contains("truth_attitudes"));
  const Outcome again = chasles(folder, "evaluate positions --json");
  EXPECT_TRUE(Json::parse(again.out).at("attitude_deg").is_null());
  // The recording's own truth, too.
  const std::string poses = slurp(folder / "rec/truth.tum");
  spill(folder / "rec/truth.tum", "# time_ns x y z\n" + text);
  EXPECT_FALSE(read_recording(folder / "rec").truth_attitudes);
  const Outcome own = chasles(folder, "run rec --quiet --json");
  ASSERT_EQ(own.code, 0) << own.err;
  EXPECT_EQ(Json::parse(own.out).at("ate_m"), Json::parse(again.out).at("ate_m"));
  EXPECT_EQ(Json::parse(own.out).at("truth_attitudes"), false);
  EXPECT_EQ(chasles(folder, "check rec").code, 0);
  EXPECT_NE(chasles(folder, "run rec --begin truth").err.find("has positions alone"),
            std::string::npos);
  spill(folder / "rec/truth.tum", poses);
  EXPECT_EQ(chasles(folder, "report positions -o page.html --quiet").code, 0);
}

TEST_F(CliTruth, FrameUnitAndInverseAreMended) {
  const double right = evaluated("rec/truth.tum").at("nees_pose");
  const auto near = [&](const std::string& arguments) {
    const Json json = evaluated(arguments);
    EXPECT_EQ(finding(json), "") << arguments;
    EXPECT_NEAR(json.at("nees_pose").get<double>(), right, 1e-3 * right) << arguments;
  };
  const SE3 imu_T_cam = read_recording(folder / "rec").cameras.at(0).cam_T_imu.inverse();
  write("of_cam0.tum", [&](StampedPose& row) { row.pose = row.pose * imu_T_cam; });
  EXPECT_EQ(finding(evaluated("of_cam0.tum")), "frame");
  near("of_cam0.tum --truth-frame cam0");
  const SE3 marker{so3::exp({M_PI / 2, 0, 0}), {0.1, 0.2, 0.3}};
  write("of_marker.tum", [&](StampedPose& row) { row.pose = row.pose * marker; });
  spill(folder / "marker.txt", "# imu_T_truth\n1 0 0 0.1\n0 0 -1 0.2\n0 1 0 0.3\n0 0 0 1\n");
  spill(folder / "marker.yaml",
        "truth_T_imu: [[1, 0, 0, -0.1], [0, 0, 1, -0.3], [0, -1, 0, 0.2], [0, 0, 0, 1]]\n");
  near("of_marker.tum --truth-frame marker.txt");
  near("of_marker.tum --truth-frame marker.yaml");
  write("mm.tum", [](StampedPose& row) { row.pose.p *= 1000; });
  EXPECT_EQ(finding(evaluated("mm.tum")), "unit");
  near("mm.tum --truth-scale 0.001");
  write("inverse.tum", [](StampedPose& row) { row.pose = row.pose.inverse(); });
  EXPECT_EQ(finding(evaluated("inverse.tum")), "inverse_poses");
  near("inverse.tum --truth-inverse");
  spill(folder / "short.txt", "1 0 0\n");
  const Outcome few = chasles(folder, "evaluate out mm.tum --truth-frame short.txt");
  EXPECT_EQ(few.code, 2);
  EXPECT_NE(few.err.find("short.txt: has 3 numbers, expected 16"), std::string::npos) << few.err;
  const Outcome none = chasles(folder, "evaluate out mm.tum --truth-frame cam7");
  EXPECT_NE(none.err.find("found 'cam7', expected imu, cam0"), std::string::npos) << none.err;
}

// A camera's poses relative to its first: the level of that world is decided before the move.
TEST_F(CliTruth, AWorldThatIsNotLevelIsKnownBeforeTheFrameIsMended) {
  const double right = evaluated("rec/truth.tum").at("ate_posyaw_m");
  const SE3 imu_T_cam = read_recording(folder / "rec").cameras.at(0).cam_T_imu.inverse();
  const SE3 first = (truth.front().pose * imu_T_cam).inverse();
  write("first.tum", [&](StampedPose& row) { row.pose = first * row.pose * imu_T_cam; });
  const Json json = evaluated("first.tum --truth-frame cam0");
  EXPECT_NEAR(json.at("ate_posyaw_m").get<double>(), right, 0.05 * right + 1e-3);
  EXPECT_GT(json.at("truth_tilt_deg").get<double>(), 45);
  const Outcome run =
      chasles(folder, "run rec --truth first.tum --truth-frame cam0 --quiet --json");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_NEAR(Json::parse(run.out).at("ate_posyaw_m").get<double>(), right, 0.05 * right + 1e-3);
}

TEST_F(CliTruth, CheckNamesTheUnitAndNotWhatFollowsFromIt) {
  write("mm.tum", [](StampedPose& row) { row.pose.p *= 1000; });
  const Outcome check = chasles(folder, "check rec --truth mm.tum");
  EXPECT_NE(check.out.find("millimetres"), std::string::npos) << check.out;
  EXPECT_EQ(check.out.find("gravity leans"), std::string::npos) << check.out;
  // A finding without a limit states none.
  write("inverse.tum", [](StampedPose& row) { row.pose = row.pose.inverse(); });
  const Outcome inverse = chasles(folder, "check rec --truth inverse.tum");
  EXPECT_NE(inverse.out.find("imu_R_world"), std::string::npos) << inverse.out;
  EXPECT_EQ(inverse.out.find("limit 0"), std::string::npos) << inverse.out;
  EXPECT_EQ(chasles(folder, "check rec").out.find("the accelerometer: "), std::string::npos);
}

TEST_F(CliTruth, RunStatesTheOffsetOfAClockThatIsHoursOff) {
  write("late.tum", [](StampedPose& row) { row.time += std::chrono::hours(1); });
  const Outcome run = chasles(folder, "run rec --truth late.tum --quiet");
  EXPECT_EQ(run.code, 2);
  EXPECT_NE(run.err.find("--truth-time-offset -3600.0"), std::string::npos) << run.err;
}

TEST_F(CliTruth, OneThatIsGivenReplacesTheRemarkThatThereIsNone) {
  std::string table =
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
      "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
  for (const ImuSample& sample : read_recording(folder / "rec").imu) {
    table += std::to_string(sample.time.count());
    for (int i = 0; i < 3; ++i) table += "," + std::to_string(sample.angular_rate_imu[i]);
    for (int i = 0; i < 3; ++i) table += "," + std::to_string(sample.specific_force_imu[i]);
    table += "\n";
  }
  spill(folder / "alone_imu.csv", table);
  const Outcome without = chasles(folder, "check alone_imu.csv");
  EXPECT_NE(without.out.find("no truth: "), std::string::npos) << without.out << without.err;
  const Outcome with = chasles(folder, "check alone_imu.csv --truth rec/truth.tum");
  EXPECT_EQ(with.out.find("no truth: "), std::string::npos) << with.out << with.err;
}

}  // namespace
}  // namespace chasles::test
