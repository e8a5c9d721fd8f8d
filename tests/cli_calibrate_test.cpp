#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "cli_process.hpp"

// `chasles calibrate cameras` and `imu-cameras`.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

constexpr const char* kTarget =
    "target_type: aprilgrid\ntagCols: 6\ntagRows: 6\ntagSize: 0.088\ntagSpacing: 0.3\n";

namespace fs = std::filesystem;

// A recording of EuRoC; none where there are no recordings.
std::optional<fs::path> recorded(const std::string& name) {
  const char* given = std::getenv("CHASLES_DATA");
  const fs::path data = given ? given : fs::path(CHASLES_SOURCE_DIR) / ".." / "shared" / "data";
  const fs::path recording = fs::absolute(data) / "euroc" / name;
  return fs::exists(recording) ? std::optional(recording) : std::nullopt;
}

std::string quoted(const fs::path& path) { return " '" + path.string() + "' "; }

double value(const Json& result, const std::string& name, const char* key = "value") {
  for (const Json& one : result.at("parameters")) {
    if (one.at("name") == name) return one.at(key);
  }
  ADD_FAILURE() << "no " << name;
  return 0;
}

TEST(CalibrateCameras, RealCornersGiveLensesAndABaselineWithSigmas) {
  const auto april = recorded("imu_april");
  if (!april) GTEST_SKIP() << "no recordings";
  const Scratch folder;
  spill(folder / "board.yaml", kTarget);
  const Outcome outcome =
      chasles(folder, "calibrate cameras" + quoted(*april) +
                          "--target board.yaml --lens equidistant --every 10 --json -o out");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json result = Json::parse(outcome.out);
  const Json& camera = result.at("cameras")[0];
  EXPECT_LT(camera.at("rms_px").get<double>(), 0.6);
  EXPECT_LT(camera.at("rms_px"), camera.at("rms_before_px"));
  // The board's bend and the factory's baseline, 110.07 mm.
  const double x = value(result, "cam1.position_x"),
               sigma = value(result, "cam1.position_x", "sigma");
  EXPECT_NEAR(x, -0.11007, std::max(0.0005, 4 * sigma));
  EXPECT_LT(sigma, 0.001);
  EXPECT_LT(std::abs(value(result, "cam0.fx", "halves_difference")),
            4 * value(result, "cam0.fx", "halves_sigma"));
  EXPECT_TRUE(fs::exists(folder / "out/page.html"));
  for (const char* file : {"calibration.yaml", "kalibr/camchain.yaml", "ros/cam0.yaml",
                           "opencv/cam1.yaml", "basalt/calibration.json", "colmap/cameras.txt"}) {
    EXPECT_TRUE(fs::exists(folder / "out" / file)) << file;
  }
  const Outcome again =
      chasles(folder, "calibrate cameras" + quoted(*april) +
                          "--target board.yaml --lens equidistant --every 10 --json -o again");
  EXPECT_TRUE(again.out == outcome.out) << "the same bytes";
}

TEST(CalibrateImuCameras, RealCornersGiveMountingAndClock) {
  const auto april = recorded("imu_april");
  if (!april) GTEST_SKIP() << "no recordings";
  const Scratch folder;
  spill(folder / "board.yaml", kTarget);
  const Outcome outcome =
      chasles(folder, "calibrate imu-cameras" + quoted(*april) +
                          "--target board.yaml --lens equidistant --every 4 --json -o out");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json result = Json::parse(outcome.out);
  // The cameras are triggered by the IMU.
  EXPECT_LT(std::abs(value(result, "cam0.time_offset")),
            4 * value(result, "cam0.time_offset", "sigma"));
  EXPECT_LT(value(result, "cam0.time_offset", "sigma"), 1e-4);
  const Json& T = result.at("cameras")[0].at("cam_T_imu");
  EXPECT_NEAR(T[0][1].get<double>(), 1, 0.01) << "turned by a quarter";
  EXPECT_TRUE(fs::exists(folder / "out/kalibr/camchain-imucam.yaml"));
  expect_part(slurp(folder / "out/page.html"), "cam1.time_offset");
  EXPECT_EQ(Json::parse(slurp(folder / "out/imu-cameras.json")), result) << "with all remarks";
  EXPECT_EQ(chasles(folder, "calibrate convert out -o again --quiet").code, 0)
      << "the result is a calibration that is read";
  // Its sigmas are settings of a run.
  ASSERT_EQ(chasles(folder, "simulate turntable --set revolutions=0.15 -o rec --quiet").code, 0);
  const Outcome run = chasles(folder, "run rec --config out/run.yaml --json --quiet");
  EXPECT_EQ(run.code, 0) << run.err;
}

TEST(CalibrateImuCameras, TwoRecordingsCountTogether) {
  const auto april = recorded("imu_april");
  if (!april) GTEST_SKIP() << "no recordings";
  const Scratch folder;
  spill(folder / "board.yaml", kTarget);
  fs::copy(*april, folder / "again");
  const std::string options = "--target board.yaml --lens equidistant --every 4 --json";
  const Outcome one = chasles(folder, "calibrate imu-cameras again " + options);
  const Outcome two =
      chasles(folder, "calibrate imu-cameras" + quoted(*april) + "again " + options);
  ASSERT_EQ(one.code, 0) << one.err;
  ASSERT_EQ(two.code, 0) << two.err;
  const Json alone = Json::parse(one.out), both = Json::parse(two.out);
  EXPECT_EQ(both.at("views"), 2 * alone.at("views").get<int>());
  EXPECT_NEAR(both.at("seconds"), 2 * alone.at("seconds").get<double>(), 0.1);
  EXPECT_EQ(both.at("recordings").size(), 2u);
  EXPECT_NEAR(both.at("recordings")[1].at("gravity_target_m_per_s2")[0],
              alone.at("gravity_target_m_per_s2")[0], 0.01);
  for (const char* name : {"cam0.position_x", "cam1.time_offset", "imu.gyroscope_scale_z"}) {
    const double sigma = value(alone, name, "sigma");
    EXPECT_NEAR(value(both, name), value(alone, name), sigma) << name;
    EXPECT_NEAR(value(both, name, "sigma"), sigma / std::sqrt(2), 0.15 * sigma) << name;
  }
}

TEST(CalibrateCameras, SaysWhatIsWrong) {
  const Scratch folder;
  spill(folder / "board.yaml", kTarget);
  ASSERT_EQ(chasles(folder, "simulate turntable --set revolutions=0.15 -o rec --quiet").code, 0);
  const Outcome tracks = chasles(folder, "calibrate cameras rec --target board.yaml");
  EXPECT_EQ(tracks.code, 2);
  expect_part(tracks.err, "is it this target");
  const Outcome lens = chasles(folder, "calibrate cameras rec --target board.yaml --lens bad");
  expect_part(lens.err, "--lens: found 'bad'");
  const Outcome target = chasles(folder, "calibrate cameras rec --target none.yaml");
  EXPECT_NE(target.code, 0);
  expect_part(target.err, "none.yaml");
  EXPECT_NE(chasles(folder, "calibrate cameras rec").code, 0) << "no target";
  spill(folder / "even.yaml",
        "target_type: checkerboard\ntargetCols: 8\ntargetRows: 6\nrowSpacingMeters: "
        "0.03\ncolSpacingMeters: 0.03\n");
  const Outcome even = chasles(folder, "calibrate imu-cameras rec --target even.yaml");
  EXPECT_EQ(even.code, 2);
  expect_part(even.err, "looks the same after half a turn");
  expect_part(chasles(folder, "calibrate imu-cameras rec rec").err, "rec: is there twice");
  expect_part(chasles(folder, "calibrate imu-cameras rec again").err,
              "found 2 recordings without --target, expected one");
}

// The mounting that the images show, from a wrong one.
TEST(CalibrateImuCameras, WithoutATargetAMotionShowsTheMounting) {
  const auto flight = recorded("MH_01_easy_17s");
  if (!flight) GTEST_SKIP() << "no recordings";
  const Scratch folder;
  const Outcome outcome = chasles(
      folder, "calibrate imu-cameras" + quoted(*flight) + "--from-nothing --json --quiet -o out");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json result = Json::parse(outcome.out);
  for (const auto& [name, published] :
       {std::pair("imu_T_cam0_x", -0.0216), {"imu_T_cam0_y", -0.0647}, {"imu_T_cam0_z", 0.0098}}) {
    EXPECT_NEAR(value(result, name, "estimate"), published, 4 * value(result, name, "sigma"));
    EXPECT_LT(value(result, name, "sigma"), 0.02);
  }
  EXPECT_TRUE(fs::exists(folder / "out/calibration.yaml"));
}

}  // namespace
}  // namespace chasles::test
