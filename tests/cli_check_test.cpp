#include <functional>

#include <nlohmann/json.hpp>

#include <chasles/data/readers.hpp>
#include <chasles/lie/so3.hpp>

#include "cli_test.hpp"

// `chasles check` on a simulated walk, without a fault and with one.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

/// A walk around one corner, from a rest of two seconds.
void simulate_walk(const Scratch& folder) {
  const Outcome made = chasles(folder,
                               "simulate hallway -o walk --quiet --set sections=2 --set "
                               "pixel_sigma=0.5 --set rest_duration=2 --set start_duration=1");
  ASSERT_EQ(made.code, 0) << made.err;
}

/// The walk with a fault, as "bad".
void spoil(const Scratch& folder, const std::function<void(Recording&)>& fault) {
  Recording recording = read_folder_recording(folder / "walk");
  fault(recording);
  write_folder_recording(recording, folder / "bad");
}

/// The finding whose sentence holds `part`.
Json finding(const Outcome& outcome, const std::string& part) {
  const Json report = Json::parse(outcome.out);
  for (const Json& f : report["findings"]) {
    if (f["what"].get<std::string>().find(part) != std::string::npos) return f;
  }
  ADD_FAILURE() << "no finding with '" << part << "' in\n" << report["findings"].dump(1);
  return {};
}

TEST(Check, ACleanRecordingGivesNoFinding) {
  const Scratch folder;
  simulate_walk(folder);
  const Outcome text = chasles(folder, "check walk");
  EXPECT_EQ(text.code, 0) << text.out;
  expect_part(text.out, "Nothing found that a filter would mind.");
  expect_part(text.out, "rate 28 Hz");
  const Outcome json = chasles(folder, "check walk --json");
  EXPECT_EQ(json.code, 0);
  const Json report = Json::parse(json.out);
  EXPECT_EQ(report["name"], "hallway");
  EXPECT_TRUE(report["findings"].empty());
  EXPECT_TRUE(report["not_checked"].empty()) << report["not_checked"];
  EXPECT_NEAR(report["facts"]["imu"]["rate"]["value"].get<double>(), 100, 1e-6);
  EXPECT_NEAR(report["facts"]["imu"]["at rest"]["value"].get<double>(), 2, 0.6);
  EXPECT_EQ(chasles(folder, "check walk --json").out, json.out) << "the same bytes";
}

TEST(Check, ALateCameraIsNamedWithItsDelay) {
  const Scratch folder;
  simulate_walk(folder);
  spoil(folder, [](Recording& r) {
    for (FeatureFrame& frame : r.frames) frame.time += std::chrono::milliseconds(30);
    r.truth.clear();
    r.true_motion.clear();
  });
  const Outcome outcome = chasles(folder, "check bad --json");
  EXPECT_EQ(outcome.code, 2);
  const Json late = finding(outcome, "looks late by");
  EXPECT_EQ(late["severity"], "error");
  EXPECT_EQ(late["about"], "cam0");
  EXPECT_NEAR(late["value"].get<double>(), 30, 5);
  expect_part(chasles(folder, "check bad").out, "error    cam0: the camera looks late by");
}

TEST(Check, InvertedAndTurnedExtrinsicsAreNamed) {
  const Scratch folder;
  simulate_walk(folder);
  spoil(folder, [](Recording& r) { r.cameras[0].cam_T_imu = r.cameras[0].cam_T_imu.inverse(); });
  finding(chasles(folder, "check bad --json"), "the extrinsics look inverted");
  spoil(folder, [](Recording& r) {
    Eigen::Matrix3d& R = r.cameras[0].cam_T_imu.R;
    R = so3::exp(Eigen::Vector3d(0.6, 0.8, 0) * 5 * M_PI / 180) * R;
  });
  const Json off = finding(chasles(folder, "check bad --json"), "rotation against the IMU is off");
  EXPECT_NEAR(off["value"].get<double>(), 5, 1.5);
}

TEST(Check, MisuseAndBadInputAreTold) {
  const Scratch folder;
  expect_error(chasles(folder, "check"), 1, "RECORDING is required");
  expect_error(chasles(folder, "check missing"), 2, "missing: no such file or folder");
  expect_error(chasles(folder, "check . --jsn"), 1, "did you mean '--json'?");
}

}  // namespace
}  // namespace chasles::test
