#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/bags/camera_info.hpp>
#include <chasles/base/error.hpp>
#include <chasles/calibration/calibration.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/calibration/foreign_writers.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/calibration/writing.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/recording/image_testing.hpp>

// Each file against the reader of its format, and against the formulas of docs/
// calibration-conventions.md. python/tests/interop/test_calibration_formats.py has the programs.
namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;
using test::scratch;

SE3 turned(double x, double y, double z, const Eigen::Vector3d& p) {
  return {so3::exp(Eigen::Vector3d(x, y, z)), p};
}

// Two cameras of the same lens at different places, with different offsets.
CalibrationToWrite pair_of(Camera camera) {
  camera.cam_T_imu = turned(0.3, -1.2, 0.7, {0.05, -0.11, 0.02});
  camera.shutter = {};
  Camera second = camera;
  second.fx += 1.25;
  second.cam_T_imu = turned(-0.1, 0.2, 1.5, {-0.2, 0.01, 1.3e-5}) * camera.cam_T_imu;
  return {.name = "pair",
          .cameras = {camera, second},
          .time_offsets = {0.0125, 0.0125},
          .has_imu = true,
          .imu_noise = ImuNoise{.accelerometer_noise_density = 0.01,
                                .accelerometer_random_walk = 2e-4,
                                .gyroscope_noise_density = 1e-5,
                                .gyroscope_random_walk = 4e-06},
          .imu_rate = 200,
          .remark = "a remark\nof two lines: # \"quoted\""};
}

CalibrationToWrite cameras_alone(const Camera& camera) {
  CalibrationToWrite result = pair_of(camera);
  const SE3 imu_T_first = result.cameras[0].cam_T_imu.inverse();
  for (Camera& c : result.cameras) c.cam_T_imu = c.cam_T_imu * imu_T_first;
  result.time_offsets.clear();
  result.has_imu = false;
  result.imu_noise.reset();
  return result;
}

void expect_same_camera(const Camera& found, const Camera& written) {
  EXPECT_EQ(found.width, written.width);
  EXPECT_EQ(found.height, written.height);
  EXPECT_TRUE(found.cam_T_imu.R.isApprox(written.cam_T_imu.R, 1e-12));
  EXPECT_LT((found.cam_T_imu.p - written.cam_T_imu.p).norm(), 1e-12);
  for (const double angle : {0.0, 0.2, 0.5}) {
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d point(std::sin(angle) * std::cos(i), std::sin(angle) * std::sin(i),
                                  std::cos(angle));
      const auto expected = project(written, point), pixel = project(found, point);
      ASSERT_TRUE(expected && pixel);
      EXPECT_EQ(pixel->pixel, expected->pixel) << name_of(written.distortion) << " " << angle;
    }
  }
}

void expect_same_noise(const ImuNoise& found, const ImuNoise& written) {
  EXPECT_EQ(found.accelerometer_noise_density, written.accelerometer_noise_density);
  EXPECT_EQ(found.accelerometer_random_walk, written.accelerometer_random_walk);
  EXPECT_EQ(found.gyroscope_noise_density, written.gyroscope_noise_density);
  EXPECT_EQ(found.gyroscope_random_walk, written.gyroscope_random_walk);
}

void expect_same(const KalibrCalibration& found, const CalibrationToWrite& written) {
  ASSERT_EQ(found.cameras.size(), written.cameras.size());
  for (std::size_t c = 0; c < found.cameras.size(); ++c) {
    expect_same_camera(found.cameras[c], written.cameras[c]);
    EXPECT_EQ(found.time_offsets[c], from_seconds(written.time_offsets[c]));
  }
  expect_same_noise(found.imu_noise, *written.imu_noise);
  EXPECT_EQ(found.imu_rate, written.imu_rate);
}

bool wrote(const WrittenCalibration& written, const fs::path& file) {
  return std::ranges::find(written.files, file) != written.files.end();
}

std::string all_left_out(const WrittenCalibration& written) {
  std::string text;
  for (const std::string& sentence : written.left_out) text += sentence + "\n";
  return text;
}

// Whether the format has the lenses. Unlike write_all(), without waiting for the disk.
bool spilled(CalibrationFiles (*files)(const CalibrationToWrite&),
             const CalibrationToWrite& calibration, const fs::path& folder) try {
  for (const CalibrationFile& file : files(calibration).files) {
    fs::create_directories((folder / file.name).parent_path());
    test::spill(folder / file.name, file.text);
  }
  return true;
} catch (const InputError&) {
  return false;
}

RosCameraInfo camera_info(const fs::path& file) {
  const YamlMap map = YamlMap::read(file, {});
  RosCameraInfo info;
  info.height = static_cast<std::uint32_t>(map.number("image_height"));
  info.width = static_cast<std::uint32_t>(map.number("image_width"));
  info.distortion_model = map.text("distortion_model");
  const std::size_t count = map.count("distortion_coefficients");
  const Eigen::VectorXd D = map.numbers("distortion_coefficients", count, "numbers");
  info.D.assign(D.begin(), D.end());
  const auto rows = [&](const char* key, std::size_t columns, auto& all) {
    const Eigen::MatrixXd M = map.matrix(key, 3, columns);
    for (std::size_t i = 0; i < 3 * columns; ++i) {
      all[i] = M(static_cast<Eigen::Index>(i / columns), static_cast<Eigen::Index>(i % columns));
    }
  };
  rows("camera_matrix", 3, info.K);
  rows("rectification_matrix", 3, info.R);
  rows("projection_matrix", 4, info.P);
  return info;
}

TEST(ForeignWriters, EveryLensComesBackFromEachFormatThatHasIt) {
  std::size_t in_kalibr = 0, in_basalt = 0, in_ros = 0;
  for (const test::Lens& lens : test::lenses()) {
    const fs::path folder = scratch();
    const CalibrationToWrite calibration = pair_of(lens.camera);
    ASSERT_TRUE(spilled(own_calibration_files, calibration, folder));
    const FolderCalibration own = read_calibration(folder / "calibration.yaml");
    for (std::size_t c = 0; c < 2; ++c) {
      expect_same_camera(own.cameras[c], calibration.cameras[c]);
      EXPECT_EQ(own.time_offsets[c], from_seconds(0.0125));
    }
    expect_same_noise(*own.imu_noise, *calibration.imu_noise);
    EXPECT_EQ(own.remarks, std::vector<std::string>{calibration.remark});
    if (spilled(kalibr_files, calibration, folder)) {
      ++in_kalibr;
      expect_same(read_kalibr(find_kalibr(folder / "kalibr").value()), calibration);
    }
    if (spilled(basalt_files, calibration, folder)) {
      ++in_basalt;
      expect_same(read_basalt(folder / "basalt/calibration.json"), calibration);
    }
    if (spilled(ros_files, calibration, folder)) {
      ++in_ros;
      for (std::size_t c = 0; c < 2; ++c) {
        const auto info = camera_info(folder / fmt::format("ros/cam{}.yaml", c));
        Camera found = camera_of(info, false, "info");
        found.cam_T_imu = calibration.cameras[c].cam_T_imu;
        expect_same_camera(found, calibration.cameras[c]);
        EXPECT_EQ(camera_of(info, true, "info").fx, calibration.cameras[c].fx);
      }
    }
    fs::remove_all(folder);
  }
  EXPECT_EQ(in_kalibr,
            9u);  // of 15 lenses: not radtan with 5, 8 and 12, division twice, fisheye624
  EXPECT_EQ(in_basalt, 9u);  // not radtan with 12, omni twice, division twice, fisheye624
  EXPECT_EQ(in_ros, 5u);     // none, radtan with 4, 5 and 8, equidistant
}

TEST(ForeignWriters, ALensThatAFormatDoesNotHaveIsNamed) {
  const auto error = [](CalibrationFiles (*files)(const CalibrationToWrite&), const Camera& lens) {
    CalibrationToWrite calibration = pair_of(test::pinhole_camera());
    calibration.cameras[1] = lens;
    return input_error([&] { files(calibration); });
  };
  const Camera division = test::lens_of(Distortion::kDivision, {0.1}, 400, 0.9).camera,
               ds = test::lens_of(Distortion::kDoubleSphere, {-0.21, 0.59}, 230, 1.5).camera;
  expect_parts(error(kalibr_files, division),
               {"cam1: Kalibr has no lens model division", "expected none, radtan", "calibrate"});
  expect_parts(error(kalibr_files, test::five_coefficient_camera()),
               {"Kalibr has no lens model radtan with 5 coefficients", "with 4 coefficients"});
  expect_parts(error(ros_files, ds),
               {"cam1: ROS's CameraInfo has no lens model ds", "equidistant"});
  expect_parts(error(opencv_files, ds), {"cam1: OpenCV has no lens model ds", "omni"});
  expect_parts(error(basalt_files, division), {"cam1: Basalt has no lens model division", "eucm"});
  expect_parts(error(colmap_files, ds), {"COLMAP has no lens model ds", "eucm"});
}

TEST(ForeignWriters, TheOtherFormatsAreWritten) {
  const fs::path folder = scratch();
  const Camera ds = test::lens_of(Distortion::kDoubleSphere, {-0.21, 0.59}, 230, 1.5).camera;
  const WrittenCalibration written = write_all(pair_of(ds), folder);
  EXPECT_TRUE(wrote(written, folder / "kalibr/camchain-imucam.yaml"));
  EXPECT_TRUE(wrote(written, folder / "kalibr/imu.yaml"));
  EXPECT_TRUE(wrote(written, folder / "basalt/calibration.json"));
  EXPECT_EQ(written.files.size(), 4u);
  expect_parts(all_left_out(written),
               {"ROS's file is not written: cam0", "OpenCV's file is not written",
                "COLMAP's file is not written"});
  EXPECT_FALSE(fs::exists(folder / "ros"));
}

TEST(ForeignWriters, WhatAFormatHasNoRoomForIsNamed) {
  const fs::path folder = scratch();
  CalibrationToWrite calibration = pair_of(test::euroc_camera());
  calibration.time_offsets = {0.001, 0.004};
  calibration.cameras[1].shutter.readout = 0.02;
  const WrittenCalibration written = write_all(calibration, folder);
  expect_parts(all_left_out(written), {"ROS's CameraInfo has no time offset, no readout time",
                                       "COLMAP's cameras.txt has no time offset",
                                       "the mean of offsets that differ by up "
                                       "to 3 ms",
                                       "OpenCV's file has no readout time"});
  const KalibrCalibration basalt = read_basalt(folder / "basalt/calibration.json");
  EXPECT_EQ(basalt.time_offsets[0], from_seconds(0.0025));
  const KalibrCalibration kalibr = read_kalibr(find_kalibr(folder / "kalibr").value());
  EXPECT_EQ(kalibr.time_offsets[1], from_seconds(0.004));
  EXPECT_EQ(kalibr.cameras[1].shutter.readout, 0.02);
  calibration.imu_noise.reset();
  calibration.imu_rate = 0;
  expect_parts(all_left_out(write_all(calibration, folder)),
               {"Kalibr's imu.yaml is not written", "zeros for the noise and the rate"});
}

TEST(ForeignWriters, CamerasAloneHaveTheFirstCameraInPlaceOfTheImu) {
  const fs::path folder = scratch();
  const CalibrationToWrite calibration = cameras_alone(test::fisheye_camera());
  const WrittenCalibration written = write_all(calibration, folder);
  ASSERT_TRUE(wrote(written, folder / "kalibr/camchain.yaml"));
  const YamlMap chain = YamlMap::read(folder / "kalibr/camchain.yaml", {});
  EXPECT_FALSE(chain.map("cam0", {}).has("T_cam_imu"));
  EXPECT_FALSE(chain.map("cam1", {}).has("timeshift_cam_imu"));
  const SE3 between = chain.map("cam1", {}).motion("T_cn_cnm1");
  EXPECT_TRUE(between.R.isApprox(calibration.cameras[1].cam_T_imu.R, 1e-12));
  EXPECT_LT((between.p - calibration.cameras[1].cam_T_imu.p).norm(), 1e-12);
  EXPECT_FALSE(fs::exists(folder / "kalibr/imu.yaml"));
  const FolderCalibration own = read_calibration(folder / "calibration.yaml");
  EXPECT_FALSE(own.imu_convention);
  expect_same_camera(own.cameras[1], calibration.cameras[1]);
}

ImuIntrinsics intrinsics(bool for_basalt) {
  ImuIntrinsics result;
  result.force << 1.01, 0, 0, 0.002, 0.98, 0, -0.003, 0.004, 1.003;
  result.rate << 0.99, 0.01, -0.02, 0.003, 1.02, 0.004, -0.005, 0.006, 1.001;
  if (for_basalt) {
    result.force_bias << 0.1, -0.2, 0.3;
    result.rate_bias << 0.01, 0.02, -0.03;
  } else {
    result.rate_of_force << 1e-4, 2e-4, 0, -3e-4, 1e-5, 0, 0, 1e-4, 2e-5;
  }
  return result;
}

void expect_same_intrinsics(const ImuIntrinsics& found, const ImuIntrinsics& written) {
  EXPECT_LT((found.force - written.force).norm(), 1e-12);
  EXPECT_LT((found.rate - written.rate).norm(), 1e-12);
  EXPECT_LT((found.rate_of_force - written.rate_of_force).norm(), 1e-12);
  EXPECT_LT((found.force_bias - written.force_bias).norm(), 1e-12);
  EXPECT_LT((found.rate_bias - written.rate_bias).norm(), 1e-12);
}

TEST(ForeignWriters, IntrinsicsOfTheImuComeBackFromKalibr) {
  const fs::path folder = scratch();
  CalibrationToWrite calibration = pair_of(test::euroc_camera());
  calibration.imu_intrinsics = intrinsics(false);
  const WrittenCalibration written = write_all(calibration, folder);
  const KalibrCalibration found = read_kalibr(find_kalibr(folder / "kalibr").value());
  expect_same(found, calibration);
  expect_same_intrinsics(found.imu_intrinsics.value(), *calibration.imu_intrinsics);
  // As Kalibr has them: C_gyro_i is a rotation, and M of the gyroscope is lower triangular.
  const YamlMap gyro =
      YamlMap::read(folder / "kalibr/imu.yaml", {}).map("imu0", {}).map("gyroscopes", {});
  const Eigen::Matrix3d C = gyro.matrix("C_gyro_i", 3, 3), M = gyro.matrix("M", 3, 3);
  EXPECT_LT((C * C.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_GT(C.determinant(), 0);
  EXPECT_LT(std::abs(M(0, 1)) + std::abs(M(0, 2)) + std::abs(M(1, 2)), 1e-15);
  expect_parts(all_left_out(written), {"Basalt's calibration.json has no intrinsics of the IMU",
                                       "calibration.yaml has no intrinsics of an IMU"});
  EXPECT_FALSE(read_basalt(folder / "basalt/calibration.json").imu_intrinsics);
}

TEST(ForeignWriters, IntrinsicsOfTheImuComeBackFromBasalt) {
  const fs::path folder = scratch();
  CalibrationToWrite calibration = pair_of(test::euroc_camera());
  calibration.imu_intrinsics = intrinsics(true);
  const WrittenCalibration written = write_all(calibration, folder);
  const KalibrCalibration found = read_basalt(folder / "basalt/calibration.json");
  expect_same_intrinsics(found.imu_intrinsics.value(), *calibration.imu_intrinsics);
  expect_parts(all_left_out(written), {"Kalibr's imu.yaml has no biases: those of 0.374 m/s^2"});
}

// PyYAML, by which Kalibr and ROS read, takes 1e-05 for a text, and Kalibr no 458 for a focal
// length.
TEST(ForeignWriters, NumbersHaveADecimalPoint) {
  EXPECT_EQ(pointed(458), "458.0");
  EXPECT_EQ(pointed(1e-5), "1.0e-05");
  EXPECT_EQ(pointed(-1.5e-7), "-1.5e-07");
  EXPECT_EQ(pointed(0.1), "0.1");
  EXPECT_EQ(pointed(1e22), "1.0e+22");
}

TEST(ForeignWriters, ARemarkStaysAComment) {
  CalibrationToWrite calibration = pair_of(test::euroc_camera());
  calibration.remark = "first\r\ncam9: {}\n";
  EXPECT_TRUE(as_comment(calibration, "last").starts_with("# first\n# cam9: {}\n# last\n"));
  const fs::path folder = scratch();
  write_all(calibration, folder);
  const YamlMap chain = YamlMap::read(folder / "kalibr/camchain-imucam.yaml", {});
  EXPECT_FALSE(chain.has("cam9"));
}

TEST(ForeignWriters, WhatIsNoCalibrationIsRejected) {
  const auto error = [](const CalibrationToWrite& calibration) {
    const fs::path folder = scratch();
    const std::string message = input_error([&] { write_all(calibration, folder); });
    EXPECT_TRUE(fs::is_empty(folder));
    return message;
  };
  expect_parts(error({.name = "none"}), {"none: the calibration has no cameras"});
  CalibrationToWrite calibration = pair_of(test::euroc_camera());
  calibration.time_offsets = {0.1};
  expect_parts(error(calibration), {"pair: found 1 time offsets, expected one for each of 2"});
  calibration = pair_of(test::euroc_camera());
  calibration.cameras[1].coefficients[2] = std::numeric_limits<double>::quiet_NaN();
  expect_parts(error(calibration), {"pair: cam1 has a number that is not finite"});
  calibration = pair_of(test::euroc_camera());
  calibration.imu_noise->gyroscope_random_walk = std::numeric_limits<double>::infinity();
  expect_parts(error(calibration), {"the noise of the IMU has a number that is not finite"});
}

}  // namespace
}  // namespace chasles
