#include <chasles/bags/bag_testing.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/recording/calibration_to_write.hpp>
#include <chasles/recording/readers.hpp>

// Where a calibration to convert comes from: as `chasles run` would take it.
namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;
using test::scratch;
using test::spill;

const std::string kCamera =
    "  - resolution: [8, 6]\n    intrinsics: [4, 4, 3.5, 2.5]\n    distortion_model: none\n"
    "    cam_T_imu: [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n";
// Kalibr's chain with an offset of both cameras.
std::string late_chain(const std::string& topic0 = "", const std::string& topic1 = "") {
  std::string chain = test::kalibr_chain(topic0, topic1);
  const std::string key = "  resolution:";
  for (std::size_t at = 0; (at = chain.find(key, at)) != std::string::npos; at += 40) {
    chain.insert(at, "  timeshift_cam_imu: -0.004\n");
  }
  return chain;
}

const std::string kHead = "format: chasles-recording-1\nname: own\n";

TEST(CalibrationToWrite, OfCamerasAlone) {
  const fs::path folder = scratch();
  spill(folder / "calibration.yaml", kHead + "cameras:\n" + kCamera);
  for (const fs::path& path : {folder, folder / "calibration.yaml"}) {
    const CalibrationToWrite found = find_calibration_to_write(path).calibration;
    EXPECT_FALSE(found.has_imu);
    EXPECT_FALSE(found.imu_noise);
    ASSERT_EQ(found.cameras.size(), 1u);
    EXPECT_EQ(found.cameras[0].cam_T_imu.p.x(), 0.5);
  }
  EXPECT_EQ(find_calibration_to_write(folder, 400).calibration.imu_rate, 400);
}

TEST(CalibrationToWrite, OfKalibrHasItsOffsetsTopicsAndRate) {
  const fs::path folder = scratch();
  spill(folder / "camchain-imucam.yaml", late_chain("/left", "/right"));
  spill(folder / "imu.yaml", std::string(test::kKalibrImu) + "rostopic: /imu\nupdate_rate: 250\n");
  for (const fs::path& path : {folder, folder / "camchain-imucam.yaml"}) {
    const CalibrationToWrite found = find_calibration_to_write(path).calibration;
    EXPECT_TRUE(found.has_imu);
    EXPECT_EQ(found.imu_rate, 250);
    EXPECT_EQ(found.camera_topics, (std::vector<std::string>{"/left", "/right"}));
    EXPECT_EQ(found.imu_topic, "/imu");
    EXPECT_EQ(found.time_offsets, (std::vector<double>{-0.004, -0.004}));
  }
}

TEST(CalibrationToWrite, OfKalibrsCamerasAlone) {
  const fs::path folder = scratch();
  std::string chain = test::kalibr_chain();
  // As kalibr_calibrate_cameras writes it: the first camera has no extrinsics.
  chain.erase(chain.find("  T_cam_imu"), chain.find("  camera_model") - chain.find("  T_cam_imu"));
  chain.replace(chain.find("T_cam_imu"), 9, "T_cn_cnm1");
  spill(folder / "camchain.yaml", chain);
  const CalibrationToWrite found = find_calibration_to_write(folder / "camchain.yaml").calibration;
  EXPECT_FALSE(found.has_imu);
  ASSERT_EQ(found.cameras.size(), 2u);
  EXPECT_EQ(found.cameras[0].cam_T_imu.p, Eigen::Vector3d::Zero());
  EXPECT_EQ(found.cameras[1].cam_T_imu.p.x(), 0.4);
  chain.replace(chain.find("T_cn_cnm1"), 9, "elsewhere");
  spill(folder / "camchain.yaml", chain);
  expect_parts(input_error([&] { find_calibration_to_write(folder / "camchain.yaml"); }),
               {"camchain.yaml", "'T_cam_imu': is missing"});
  // With extrinsics, and without the noise of the IMU.
  spill(folder / "chain.yaml", late_chain());
  const CalibrationToWrite with_imu = find_calibration_to_write(folder / "chain.yaml").calibration;
  EXPECT_TRUE(with_imu.has_imu);
  EXPECT_FALSE(with_imu.imu_noise);
  EXPECT_EQ(with_imu.time_offsets, (std::vector<double>{-0.004, -0.004}));
}

TEST(CalibrationToWrite, OfBasaltIsReadByItsContent) {
  const fs::path folder = scratch();
  const std::string camera =
      R"({"camera_type":"ds","intrinsics":{"fx":4,"fy":4,"cx":3.5,"cy":2.5,"xi":0.1,"alpha":0.5}})";
  const std::string three = "[0.01,0.01,0.01]";
  spill(folder / "own name.json",
        R"({"value0":{"T_imu_cam":[{"px":1,"py":0,"pz":0,"qx":0,"qy":0,"qz":0,"qw":1}],)"
        R"("intrinsics":[)" +
            camera +
            R"(],"resolution":[[8,6]],"imu_update_rate":300,)"
            R"("accel_noise_std":)" +
            three + R"(,"gyro_noise_std":)" + three + R"(,"accel_bias_std":)" + three +
            R"(,"gyro_bias_std":)" + three + R"(,"cam_time_offset_ns":-3000000}})");
  for (const fs::path& path : {folder, folder / "own name.json"}) {
    const CalibrationToWrite found = find_calibration_to_write(path).calibration;
    EXPECT_EQ(found.cameras.at(0).distortion, Distortion::kDoubleSphere);
    EXPECT_EQ(found.cameras[0].cam_T_imu.p.x(), -1);
    EXPECT_EQ(found.time_offsets, std::vector<double>{-0.003});
    EXPECT_EQ(found.imu_rate, 300);
  }
}

TEST(CalibrationToWrite, OfVinsNeedsTheRateOfTheSamples) {
  const fs::path folder = scratch();
  spill(folder / "vins.yaml",
        "%YAML:1.0\nimu: 1\nnum_of_cam: 1\nimage_width: 8\nimage_height: 6\n"
        "model_type: PINHOLE\nestimate_extrinsic: 0\n"
        "distortion_parameters: {k1: 0, k2: 0, p1: 0, p2: 0}\n"
        "projection_parameters: {fx: 4, fy: 4, cx: 3.5, cy: 2.5}\n"
        "extrinsicRotation: !!opencv-matrix\n  rows: 3\n  cols: 3\n  dt: d\n"
        "  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
        "extrinsicTranslation: !!opencv-matrix\n  rows: 3\n  cols: 1\n  dt: d\n"
        "  data: [0.5, 0, 0]\n"
        "acc_n: 0.1\ngyr_n: 0.01\nacc_w: 0.001\ngyr_w: 0.0001\ntd: 0.002\n");
  expect_parts(input_error([&] { find_calibration_to_write(folder / "vins.yaml"); }),
               {"the noise of VINS", "--imu-rate"});
  const CalibrationToWrite found = find_calibration_to_write(folder / "vins.yaml", 400).calibration;
  EXPECT_NEAR(found.imu_noise->accelerometer_noise_density, 0.1 / 20, 1e-15);
  EXPECT_EQ(found.imu_rate, 400);
  EXPECT_EQ(found.time_offsets, std::vector<double>{0.002});
}

TEST(CalibrationToWrite, OfAnEurocFolderHasTheRateOfItsImu) {
  const fs::path folder = scratch();
  test::write_euroc_folder(folder, 2);
  const CalibrationToWrite found = find_calibration_to_write(folder).calibration;
  const Recording recording = read_recording(folder);
  ASSERT_EQ(found.cameras.size(), recording.cameras.size());
  EXPECT_EQ(found.cameras[1].cam_T_imu.p, recording.cameras[1].cam_T_imu.p);
  EXPECT_EQ(found.imu_noise->gyroscope_random_walk, recording.imu_noise->gyroscope_random_walk);
}

// The reader of a bag has added the offsets to the stamps.
TEST(CalibrationToWrite, OfABagHasTheOffsetsOfTheFilesBesideIt) {
  const fs::path folder = scratch();
  spill(folder / "camchain-imucam.yaml", late_chain());
  spill(folder / "imu.yaml", test::kKalibrImu);
  fs::copy_file(test::written_bag("none.bag"), folder / "none.bag");
  const CalibrationToWrite found = find_calibration_to_write(folder / "none.bag").calibration;
  ASSERT_EQ(found.cameras.size(), 2u);
  EXPECT_EQ(found.time_offsets, (std::vector<double>{-0.004, -0.004}));
  EXPECT_GT(found.imu_rate, 1);
}

TEST(CalibrationToWrite, WhatHasNoCamerasIsRejected) {
  const fs::path folder = scratch();
  const auto error = [&](const fs::path& path) {
    return input_error([&] { find_calibration_to_write(path); });
  };
  expect_parts(error(folder / "none.yaml"), {"none.yaml"});
  spill(folder / "imu.yaml", test::kKalibrImu);
  expect_parts(error(folder / "imu.yaml"), {"imu.yaml: has an IMU alone"});
  spill(folder / "other.yaml", "size: 7\n");
  expect_parts(error(folder / "other.yaml"), {"other.yaml: is no calibration"});
  spill(folder / "rig.yaml", kHead +
                                 "fx: 4\nfy: 4\ncx: 3\ncy: 2\nbaseline: 0.1\ncam0_T_imu: "
                                 "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n");
  expect_parts(error(folder / "rig.yaml"), {"a rectified stereo pair, whose images have no size"});
}

}  // namespace
}  // namespace chasles
