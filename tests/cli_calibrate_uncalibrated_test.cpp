#include <csignal>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/calibrate/inertial_testing.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/codec/image_encode.hpp>
#include <chasles/target/target_testing.hpp>

#include "cli_process.hpp"

// `chasles calibrate imu-cameras` of images and a table, without a calibration.
namespace chasles::test {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kFirst = 1'400'000'000'000'000'000;

// Rendered images of a board before a moving rig, and the samples of its IMU.
void record(const Scratch& folder, const BoardRigScene& scene) {
  const TargetRenderer renderer(april_board(), scene.cameras[0]);
  const BoardMotion motion(scene.turning);
  fs::create_directories(folder / "rec/cam0");
  const int frames = static_cast<int>(scene.seconds * scene.frame_rate);
  for (int k = 0; k < frames; ++k) {
    const double t = 1 + k / scene.frame_rate;
    const SE3 cam_T_target = scene.cameras[0].cam_T_imu * motion.target_T_imu(t).inverse();
    const auto seed = static_cast<std::uint64_t>(k + 1);
    spill(folder / fmt::format("rec/cam0/{}.png", kFirst + std::llround(1e9 * t)),
          png_bytes(renderer.render(cam_T_target, {.seed = seed})));
  }
  BoardRigScene samples = scene;
  samples.frame_rate = 0.01;
  std::string table = "timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n";
  for (const ImuSample& sample : inertial_views(samples, 1).imu) {
    const Eigen::Vector3d &w = sample.angular_rate_imu, &f = sample.specific_force_imu;
    table += fmt::format("{},{},{},{},{},{},{}\n", kFirst + sample.time.count(), w.x(), w.y(),
                         w.z(), f.x(), f.y(), f.z());
  }
  spill(folder / "rec/imu.csv", table);
}

TEST(CalibrateImuCameras, AFolderWithoutACalibrationIsEnough) {
  const Scratch folder;
  Camera camera = euroc_camera();
  camera.cam_T_imu = {so3::exp(Eigen::Vector3d(0.02, -0.01, 1.55)), {0.06, -0.02, 0.01}};
  const BoardRigScene scene{.cameras = {camera}, .seconds = 8, .frame_rate = 8};
  record(folder, scene);
  spill(folder / "board.yaml",
        "target_type: aprilgrid\ntagCols: 6\ntagRows: 6\ntagSize: 0.088\ntagSpacing: 0.3\n");
  spill(folder / "noise.yaml",
        "accelerometer_noise_density: 2.0e-3\naccelerometer_random_walk: 3.0e-4\n"
        "gyroscope_noise_density: 1.7e-4\ngyroscope_random_walk: 2.0e-5\n"
        "rostopic: /imu0\nupdate_rate: 200.0\n");
  const std::string command = "calibrate imu-cameras rec --target board.yaml --lens radtan --json ";
  const Outcome unknown = chasles(folder, command);
  EXPECT_EQ(unknown.code, 2);
  expect_part(unknown.err, "by --imu-noise FILE");
  const Outcome outcome = chasles(folder, command + "--imu-noise noise.yaml -o out");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const nlohmann::json T = nlohmann::json::parse(outcome.out).at("cameras")[0].at("cam_T_imu");
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(T[i][3].get<double>(), camera.cam_T_imu.p[i], 0.003);
    for (int j = 0; j < 3; ++j) {
      EXPECT_NEAR(T[i][j].get<double>(), camera.cam_T_imu.R(i, j), 0.002);
    }
  }
  expect_part(slurp(folder / "out/kalibr/imu.yaml"), "0.00017");
  fs::copy(folder / "noise.yaml", folder / "rec/imu.yaml");
  const Outcome with_file = chasles(folder, command);
  using nlohmann::json;  // the remarks of -o are about its files
  EXPECT_EQ(json::parse(with_file.out).at("cameras"), json::parse(outcome.out).at("cameras"));
  Process live(folder, {"calibrate", "imu-cameras", (folder / "rec").string(), "--target",
                        (folder / "board.yaml").string(), "--lens", "radtan", "--json", "--live"});
  EXPECT_TRUE(live.shows("64 views")) << live.output();
  EXPECT_EQ(live.code_after(SIGINT), 0) << live.output();
  EXPECT_TRUE(live.output().ends_with(with_file.out)) << "the same bytes";
  fs::remove(folder / "rec/imu.csv");
  fs::remove(folder / "rec/imu.yaml");
  const Outcome images = chasles(folder, command);
  EXPECT_EQ(images.code, 2);
  expect_part(images.err, "has no samples of an IMU");
}

}  // namespace
}  // namespace chasles::test
