#include <algorithm>
#include <functional>
#include <sstream>

#include <nlohmann/json.hpp>

#include <chasles/lie/so3.hpp>
#include <chasles/recording/readers.hpp>

#include "cli_test.hpp"

// `chasles check` on a simulated walk, without deficiency and with one.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

/// A walk around one corner, after a standstill of two seconds.
void simulate_walk(const Scratch& folder) {
  const Outcome made = chasles(folder,
                               "simulate hallway -o walk --quiet --set sections=2 --set "
                               "pixel_sigma=0.5 --set rest_duration=2 --set start_duration=1");
  ASSERT_EQ(made.code, 0) << made.err;
}

/// The walk with a deficiency, as "bad".
void spoil(const Scratch& folder, const std::function<void(Recording&)>& fault) {
  Recording recording = read_folder_recording(folder / "walk");
  fault(recording);
  write_folder_recording(recording, folder / "bad");
}

/// The finding whose sentence contains `part`.
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
  expect_part(text.out, "No findings.");
  expect_part(text.out, "rate 28 Hz");
  const Outcome json = chasles(folder, "check walk --json");
  EXPECT_EQ(json.code, 0);
  const Json report = Json::parse(json.out);
  EXPECT_EQ(report["name"], "hallway");
  EXPECT_TRUE(report["findings"].empty());
  EXPECT_TRUE(report["not_checked"].empty()) << report["not_checked"];
  EXPECT_NEAR(report["facts"]["imu"]["rate"]["value"].get<double>(), 100, 1e-6);
  EXPECT_NEAR(report["facts"]["imu"]["at rest"]["value"].get<double>(), 2, 0.6);
  EXPECT_GT(report["facts"]["filter"]["estimates"]["value"].get<double>(), 90);
  EXPECT_EQ(chasles(folder, "check walk --json").out, json.out) << "the same bytes";
}

// By batch estimation, whose sigmas say what is far.
TEST(CheckCalibration, ALensIsComparedWithTheMotion) {
  const Scratch folder;
  simulate_walk(folder);
  const Json right = Json::parse(chasles(folder, "check walk --calibration --json").out);
  EXPECT_TRUE(right["findings"].empty()) << right["findings"];
  const Json& facts = right["facts"];
  for (const char* what : {"lens", "mounting", "place on the IMU"}) {
    EXPECT_LT(facts["cam0"][what + std::string(" against the motion over its sigma")]["value"], 4);
  }
  EXPECT_LT(facts["cameras"]["clock against the motion over its sigma"]["value"], 4);
  spoil(folder, [](Recording& r) {
    r.cameras[0].fx *= 1.04;
    r.cameras[0].fy *= 1.04;
  });
  const Outcome wrong = chasles(folder, "check bad --calibration --json");
  const Json lens = finding(wrong, "its lens is off by");
  EXPECT_EQ(lens["about"], "cam0");
  EXPECT_EQ(lens["severity"], "warning");
  EXPECT_GT(lens["value"], 4);
  const Outcome nothing = chasles(folder, "check bad --json");
  EXPECT_EQ(nothing.out.find("against the motion"), std::string::npos);
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
  const Json late = finding(outcome, "is stamped late by");
  EXPECT_EQ(late["severity"], "error");
  EXPECT_EQ(late["about"], "cam0");
  EXPECT_NEAR(late["value"].get<double>(), 30, 5);
  expect_part(chasles(folder, "check bad").out, "error    cam0: the camera is stamped late by");
}

TEST(Check, InvertedAndTurnedExtrinsicsAreNamed) {
  const Scratch folder;
  simulate_walk(folder);
  spoil(folder, [](Recording& r) { r.cameras[0].cam_T_imu = r.cameras[0].cam_T_imu.inverse(); });
  finding(chasles(folder, "check bad --json"), "the extrinsics seem to be inverted");
  spoil(folder, [](Recording& r) {
    Eigen::Matrix3d& R = r.cameras[0].cam_T_imu.R;
    R = so3::exp(Eigen::Vector3d(0.6, 0.8, 0) * 5 * M_PI / 180) * R;
  });
  const Json off = finding(chasles(folder, "check bad --json"), "rotation against the IMU is off");
  EXPECT_NEAR(off["value"].get<double>(), 5, 1.5);
}

// Without a truth. The filter itself shows with which change it works.
TEST(Check, AWrongSignAxisOrUnitOfTheImuIsNamed) {
  const Scratch folder;
  simulate_walk(folder);
  struct Fault {
    const char* cure;
    std::function<void(ImuSample&)> put_in;
  };
  const Fault faults[] = {
      {"with the sign of the accelerometer changed",
       [](ImuSample& s) { s.specific_force_imu *= -1; }},
      {"with the gyroscope's numbers taken as deg/s",
       [](ImuSample& s) { s.angular_rate_imu *= 180 / M_PI; }},
      {"with the accelerometer's numbers taken as g",
       [](ImuSample& s) { s.specific_force_imu /= kStandardGravity; }},
      {"with the z axis of the gyroscope changed in sign",
       [](ImuSample& s) { s.angular_rate_imu.z() *= -1; }},
  };
  for (const Fault& fault : faults) {
    SCOPED_TRACE(fault.cure);
    spoil(folder, [&](Recording& r) {
      std::ranges::for_each(r.imu, fault.put_in);
      r.truth.clear();
      r.true_motion.clear();
    });
    const Outcome outcome = chasles(folder, "check bad --json");
    EXPECT_EQ(outcome.code, 2);
    const Json found = finding(outcome, "the filter ");
    EXPECT_EQ(found["severity"], "error");
    expect_part(found["advice"].get<std::string>(), fault.cure);
  }
}

// 50 ms at the edge of every range, with ranges that are stated, or detected from the samples.
TEST(Saturation, IsFoundAndARunGoesOnThroughIt) {
  const Scratch folder;
  simulate_walk(folder);
  const double clean =
      Json::parse(chasles(folder, "run walk --json --quiet").out)["ate_posyaw_m"].get<double>();
  for (const bool stated : {true, false}) {
    spoil(folder, [&](Recording& r) {
      const Time from = r.imu.front().time + std::chrono::seconds(6);
      for (ImuSample& s : r.imu) {
        if (s.time < from || s.time >= from + std::chrono::milliseconds(50)) continue;
        s.specific_force_imu.setConstant(156.9);
        s.angular_rate_imu.setConstant(17.45);
      }
      if (stated) r.imu_range = {.accelerometer = 156.9, .gyroscope = 17.45};
    });
    EXPECT_EQ(finding(chasles(folder, "check bad --json"), "edge of the sensor's range")["value"],
              5);
    const Outcome run = chasles(folder, "run bad --json --quiet");
    ASSERT_EQ(run.code, 0) << run.err;
    const Json summary = Json::parse(run.out);
    EXPECT_EQ(summary["imu"]["saturated"], 5);
    EXPECT_EQ(summary["resets"], 0);
    EXPECT_LT(summary["ate_posyaw_m"].get<double>(), clean + 0.05);
    expect_part(summary["remarks"].dump(), "5 IMU samples at the edge of the sensor's range");
  }
}

TEST(Check, MisuseAndBadInputAreReported) {
  const Scratch folder;
  expect_error(chasles(folder, "check"), 1, "RECORDING is required");
  expect_error(chasles(folder, "check missing"), 2, "missing: no such file or folder");
  expect_error(chasles(folder, "check . --jsn"), 1, "did you mean '--json'?");
}

std::optional<std::filesystem::path> recorded_flight() {
  const char* given = std::getenv("CHASLES_DATA");
  const std::filesystem::path data =
      given ? given : std::filesystem::path(CHASLES_SOURCE_DIR) / ".." / "shared" / "data";
  const auto flight = std::filesystem::absolute(data) / "euroc/MH_01_easy_17s";
  return std::filesystem::exists(flight) ? std::optional(flight) : std::nullopt;
}

/// The flight with the given cameras, whose tables the caller may overwrite; empty without
/// recordings.
std::optional<std::filesystem::path> flight(const Scratch& folder, int cameras) {
  namespace fs = std::filesystem;
  const auto recorded = recorded_flight();
  if (!recorded) return std::nullopt;
  const fs::path real = *recorded / "mav0", own = folder / "flight/mav0";
  fs::create_directories(own);
  fs::create_symlink(real / "imu0", own / "imu0");
  for (int c = 0; c < cameras; ++c) {
    const std::string camera = "cam" + std::to_string(c);
    fs::create_directories(own / camera);
    fs::create_symlink(real / camera / "data", own / camera / "data");
    for (const char* file : {"sensor.yaml", "data.csv"}) {
      fs::copy_file(real / camera / file, own / camera / file);
    }
  }
  return own;
}

TEST(CheckImages, ARealFlightIsFoundPlausible) {
  const auto recorded = recorded_flight();
  if (!recorded) GTEST_SKIP() << "skipped: no recordings";
  const Scratch folder;
  const Outcome outcome = chasles(folder, "check '" + recorded->string() + "' --json");
  EXPECT_EQ(outcome.code, 0) << outcome.out;
  const Json report = Json::parse(outcome.out);
  EXPECT_TRUE(report["not_checked"].empty()) << report["not_checked"];
  for (const Json& finding : report["findings"]) EXPECT_NE(finding["severity"], "error") << finding;
  for (const char* camera : {"cam0", "cam1"}) {
    const Json& facts = report["facts"][camera];
    EXPECT_NEAR(facts["offset to the gyroscope"]["value"].get<double>(), 0, 3) << camera;
    EXPECT_LT(facts["rotation off"]["value"].get<double>(), 1) << camera;
    EXPECT_NEAR(facts["turns over the gyroscope's"]["value"].get<double>(), 1, 0.03) << camera;
  }
  EXPECT_LT(report["facts"]["cam1"]["off the epipolar line"]["value"].get<double>(), 1);
}

TEST(CheckImages, ALateCameraIsNamedWithItsDelay) {
  const Scratch folder;
  const auto own = flight(folder, 1);
  if (!own) GTEST_SKIP() << "skipped: no recordings";
  std::istringstream rows(slurp(*own / "cam0/data.csv"));
  std::string table, line;
  std::getline(rows, table);
  table += "\n";
  while (std::getline(rows, line)) {
    const std::size_t comma = line.find(',');
    table +=
        std::to_string(std::stoll(line.substr(0, comma)) + 31'000'000) + line.substr(comma) + "\n";
  }
  spill(*own / "cam0/data.csv", table);
  const Outcome outcome = chasles(folder, "check flight --json");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NEAR(finding(outcome, "is stamped late by")["value"].get<double>(), 31, 3);
}

/// Writes the extrinsics of a camera into its sensor.yaml.
void place(const std::filesystem::path& camera, const SE3& imu_T_cam) {
  std::ostringstream data;
  data.precision(17);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) data << imu_T_cam.R(i, j) << ", ";
    data << imu_T_cam.p(i) << ", ";
  }
  std::string text = slurp(camera / "sensor.yaml");
  const std::size_t begin = text.find('[', text.find("data:")) + 1;
  text.replace(begin, text.find(']', begin) - begin, data.str() + "0, 0, 0, 1");
  spill(camera / "sensor.yaml", text);
}

TEST(CheckImages, InvertedExtrinsicsAreNamed) {
  const Scratch folder;
  const auto own = flight(folder, 1);
  if (!own) GTEST_SKIP() << "skipped: no recordings";
  place(*own / "cam0", read_recording(*own / "..").cameras[0].cam_T_imu);
  const Outcome outcome = chasles(folder, "check flight --json --seconds 10");
  EXPECT_EQ(outcome.code, 2);
  finding(outcome, "the extrinsics seem to be inverted");
}

TEST(CheckImages, ABaselineOfTheWrongSignIsNamed) {
  const Scratch folder;
  const auto own = flight(folder, 2);
  if (!own) GTEST_SKIP() << "skipped: no recordings";
  const auto cameras = read_recording(*own / "..").cameras;
  SE3 second = cameras[1].cam_T_imu.inverse();
  second.p = 2 * cameras[0].cam_T_imu.inverse().p - second.p;
  place(*own / "cam1", second);
  const Outcome outcome = chasles(folder, "check flight --json --seconds 3");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(finding(outcome, "would lie behind the cameras")["about"], "cam1");
}

}  // namespace
}  // namespace chasles::test
