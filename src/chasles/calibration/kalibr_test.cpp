#include <chasles/calibration/kalibr.hpp>
#include <chasles/recording/image_testing.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

const std::string kChain = R"(cam0:
  T_cam_imu:
  - [0.0, 1.0, 0.0, -0.2]
  - [-1.0, 0.0, 0.0, 0.1]
  - [0.0, 0.0, 1.0, -0.3]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 0.0001, 0.00002]
  distortion_model: radtan
  intrinsics: [458.0, 457.0, 367.0, 248.0]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
  timeshift_cam_imu: -0.0052
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.11]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [0.01, 0.02, 0.03, 0.04]
  distortion_model: equidistant
  intrinsics: [400.0, 401.0, 320.0, 240.0]
  resolution: [640, 480]
)";
const std::string kImu = R"(accelerometer_noise_density: 0.01
accelerometer_random_walk: 0.0002
gyroscope_noise_density: 0.005
gyroscope_random_walk: 4.0e-06
rostopic: /imu0
update_rate: 200.0
)";

class Kalibr : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = test::scratch();
    write(kChain, kImu);
  }
  void write(const std::string& chain, const std::string& imu) const {
    test::spill(folder / "camchain-imucam.yaml", chain);
    test::spill(folder / "imu.yaml", imu);
  }
  KalibrCalibration read() const { return read_kalibr(find_kalibr(folder).value()); }
  std::string error() const {
    return input_error([&] { read(); });
  }
  static std::string changed(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }
  fs::path folder;
};

TEST_F(Kalibr, ACameraMayHaveARollingShutter) {
  write(changed(kChain, "  rostopic: /cam0", "  readout_time: 0.031\n  rostopic: /cam0"), kImu);
  EXPECT_EQ(read().cameras[0].shutter.readout, 0.031);
  EXPECT_FALSE(read().cameras[1].shutter.is_rolling());
  write(changed(kChain, "  rostopic: /cam0", "  readout_time: 31\n  rostopic: /cam0"), kImu);
  expect_parts(error(), {"camchain-imucam.yaml", "'readout_time': is 31", "in seconds"});
}

TEST_F(Kalibr, CamerasAndImuAreReadWhole) {
  const KalibrCalibration k = read();
  ASSERT_EQ(k.cameras.size(), 2u);
  // T_cam_imu maps IMU to camera: the camera is at (0.1, 0.2, 0.3).
  EXPECT_LT((k.cameras[0].cam_T_imu * Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-15);
  EXPECT_EQ(k.cameras[0].distortion, Distortion::kRadtan);
  EXPECT_EQ(k.cameras[1].distortion, Distortion::kEquidistant);
  EXPECT_EQ(k.cameras[1].coefficients[3], 0.04);
  EXPECT_EQ(k.cameras[1].width, 640);
  EXPECT_EQ(k.camera_topics, (std::vector<std::string>{"/cam0/image_raw", ""}));
  EXPECT_EQ(k.imu_topic, "/imu0");
  EXPECT_EQ(k.imu_noise.gyroscope_random_walk, 4e-6);
  EXPECT_EQ(k.imu_noise.accelerometer_noise_density, 0.01);
  ASSERT_EQ(k.remarks.size(), 1u);
  expect_parts(k.remarks[0], {"cam0", "5.200 ms late", "corrected"});
  EXPECT_EQ(k.time_offsets, (std::vector<Time>{std::chrono::microseconds(-5200), Time::zero()}));
  EXPECT_FALSE(k.imu_intrinsics);
}

TEST_F(Kalibr, TheChainPutsTheSecondCameraToTheRightOfTheFirst) {
  const KalibrCalibration k = read();
  const Eigen::Vector3d cam1_in_cam0 =
      k.cameras[0].cam_T_imu * (k.cameras[1].cam_T_imu.inverse() * Eigen::Vector3d::Zero());
  EXPECT_LT((cam1_in_cam0 - Eigen::Vector3d(0.11, 0, 0)).norm(), 1e-15);
}

// OpenVINS's T_imu_cam is the inverse. Its files start with OpenCV's kind of header, and have the
// IMU below a key.
TEST_F(Kalibr, TheKeysNameShowsTheDirection) {
  const Camera kalibr = read().cameras[0];
  std::string chain = changed(kChain, "T_cam_imu", "T_imu_cam");
  chain = changed(chain, "[0.0, 1.0, 0.0, -0.2]", "[0.0, -1.0, 0.0, 0.1]");
  chain = changed(chain, "[-1.0, 0.0, 0.0, 0.1]", "[1.0, 0.0, 0.0, 0.2]");
  chain = changed(chain, "[0.0, 0.0, 1.0, -0.3]", "[0.0, 0.0, 1.0, 0.3]");
  std::string below = "%YAML:1.0\n\nimu0:\n";
  std::istringstream lines(kImu);
  for (std::string line; std::getline(lines, line);) below += "  " + line + "\n";
  fs::remove_all(folder);
  fs::create_directories(folder);
  test::spill(folder / "kalibr_imucam_chain.yaml", "%YAML:1.0 # the type\n\n" + chain);
  test::spill(folder / "kalibr_imu_chain.yaml", below);
  const KalibrCalibration openvins = read();
  EXPECT_LT((openvins.cameras[0].cam_T_imu.R - kalibr.cam_T_imu.R).norm(), 1e-15);
  EXPECT_LT((openvins.cameras[0].cam_T_imu.p - kalibr.cam_T_imu.p).norm(), 1e-15);
  EXPECT_EQ(openvins.imu_noise.gyroscope_noise_density, 0.005);
}

TEST_F(Kalibr, WhatCannotBeUsedIsRejectedWithItsLine) {
  const std::vector<std::array<std::string, 3>> chains{
      {"camera_model: pinhole", "camera_model: cubic", "'cubic' is a model that is not supported"},
      {"camera_model: pinhole", "camera_model: omni", "numbers: xi, fx, fy, cx, cy"},
      {"camera_model: pinhole", "camera_model: fov", "'fov' is a model that is not supported"},
      {"distortion_model: radtan", "distortion_model: cubic",
       "'cubic' is a model that is not supported"},
      {"distortion_model: radtan", "distortion_model: fov", "4 coefficients, expected 1"},
      {"T_cam_imu", "T_cam_body", "T_cam_imu': is missing, and so is T_imu_cam"},
      {"[-1.0, 0.0, 0.0, 0.1]", "[1.0, 0.0, 0.0, 0.1]", "reflection"},
      {"[-1.0, 0.0, 0.0, 0.1]", "[-2.0, 0.0, 0.0, 0.1]", "not a rotation"},
      {"[-1.0, 0.0, 0.0, 0.1]", "[-1.0, 0.0, .nan, 0.1]", "nan"},
      {"[458.0,", "[0,", "expected a positive number"},
      {"cam_overlaps: [1]", "T_imu_cam: []", "is there beside T_cam_imu"},
      {"cam0:", "camera0:", "key 'cam0' is missing"},
      {"resolution: [752, 480]", "resolution: [752]", "width, height"},
      {"cam0:", "cam0: [", "not valid YAML"}};
  for (const auto& [from, to, part] : chains) {
    write(changed(kChain, from, to), kImu);
    expect_parts(error(), {"camchain-imucam.yaml", part});
  }
  write(kChain, changed(kImu, "gyroscope_random_walk: 4.0e-06", "gyroscope_random_walk: -1"));
  expect_parts(error(), {"imu.yaml:4", "gyroscope_random_walk", "not negative"});
  write(kChain, changed(kImu, "gyroscope_random_walk", "gyro_walk"));
  expect_parts(error(), {"imu.yaml", "gyroscope_random_walk"});
  write(kChain, "");
  expect_parts(error(), {"imu.yaml"});
}

TEST_F(Kalibr, NamesOfOtherProgramsAndFiveCoefficientsAreRead) {
  std::string chain = changed(kChain, "camera_model: pinhole", "camera_model: PINHOLE");
  chain = changed(chain, "distortion_model: radtan", "distortion_model: plumb_bob");
  chain = changed(chain, "0.0001, 0.00002]", "0.0001, 0.00002, -0.3]");
  write(changed(chain, "distortion_model: equidistant", "distortion_model: equi"), kImu);
  const KalibrCalibration k = read();
  EXPECT_EQ(k.cameras[0].distortion, Distortion::kRadtan);
  EXPECT_EQ(k.cameras[0].coefficients, (LensCoefficients{-0.28, 0.07, 0.0001, 0.00002, -0.3}));
  EXPECT_EQ(k.cameras[1].distortion, Distortion::kEquidistant);
  // OpenCV's list of eight: zeros behind the fifth are no model of their own.
  write(changed(kChain, "0.0001, 0.00002]", "0.0001, 0.00002, 0, 0, 0, 0]"), kImu);
  EXPECT_EQ(read().cameras[0].coefficients.size(), 4u);
  write(changed(kChain, "0.0001, 0.00002]", "0.0001, 0.00002, 0, 0.1, 0, 0]"), kImu);
  EXPECT_EQ(read().cameras[0].coefficients.size(), 8u);
  EXPECT_EQ(read().cameras[0].coefficients[5], 0.1);
  write(changed(kChain, "0.0001, 0.00002]", "0.0001, 0.00002, 0, 0.1]"), kImu);
  expect_parts(error(), {"camchain-imucam.yaml:9", "6 coefficients, expected 4, 5, 8 or 12"});
  write(changed(kChain, "0.0001, 0.00002]", "0.0001, 0.00002, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0]"),
        kImu);
  expect_parts(error(), {"14 coefficients", "tilted sensor"});
  write(changed(kChain, "[0.01, 0.02, 0.03, 0.04]", "[0.01, 0.02, 0.03, 0.04, 0]"), kImu);
  expect_parts(error(), {"distortion_coeffs", "has 5 coefficients, expected 4"});
}

// [xi alpha fu fv pu pv] and so on, as Kalibr's page of supported models has them.
TEST_F(Kalibr, LensesOfAllCameraModelsAreRead) {
  struct Model {
    const char *camera_model, *intrinsics, *distortion_model, *coefficients;
    Distortion distortion;
    LensCoefficients expected;
  };
  for (const Model& model :
       std::vector<Model>{{"omni", "1.6, ", "none", "", Distortion::kOmni, {1.6}},
                          {"omni",
                           "1.6, ",
                           "radtan",
                           "-0.1, 0.2, 0.003, -0.004",
                           Distortion::kOmni,
                           {1.6, -0.1, 0.2, 0.003, -0.004}},
                          {"ds", "-0.2, 0.6, ", "none", "", Distortion::kDoubleSphere, {-0.2, 0.6}},
                          {"eucm", "0.6, 1.1, ", "none", "", Distortion::kEucm, {0.6, 1.1}},
                          {"pinhole", "", "fov", "0.9", Distortion::kFov, {0.9}}}) {
    std::string chain = changed(kChain, "camera_model: pinhole",
                                std::string("camera_model: ") + model.camera_model);
    chain = changed(chain, "[458.0,", std::string("[") + model.intrinsics + "458.0,");
    chain = changed(chain, "distortion_model: radtan",
                    std::string("distortion_model: ") + model.distortion_model);
    const std::size_t begin = chain.find("distortion_coeffs: [") + 20, end = chain.find(']', begin);
    chain.replace(begin, end - begin, model.coefficients);
    write(chain, kImu);
    const Camera camera = read().cameras[0];
    EXPECT_EQ(camera.distortion, model.distortion) << model.camera_model;
    EXPECT_EQ(camera.coefficients, model.expected) << model.camera_model;
    EXPECT_EQ(camera.fx, 458);
  }
  std::string chain = changed(kChain, "camera_model: pinhole", "camera_model: ds");
  chain = changed(chain, "[458.0,", "[-0.2, 0.6, 458.0,");
  write(chain, kImu);
  expect_parts(error(), {"distortion_model", "is radtan, expected none with the camera_model ds"});
  chain = changed(chain, "distortion_model: radtan", "distortion_model: none");
  write(changed(chain, "0.6, 458.0", "1.6, 458.0"), kImu);
  expect_parts(error(), {"distortion_coeffs", "is not zero"});
}

// As OpenCV's FileStorage writes it, with Windows' line ends and a byte-order mark.
TEST_F(Kalibr, MatricesOfOpenCvAreRead) {
  const Camera rows = read().cameras[0];
  std::string chain =
      changed(kChain,
              "  - [0.0, 1.0, 0.0, -0.2]\n  - [-1.0, 0.0, 0.0, 0.1]\n"
              "  - [0.0, 0.0, 1.0, -0.3]\n  - [0.0, 0.0, 0.0, 1.0]\n",
              "    rows: 4\n    cols: 4\n    dt: d\n    data: [ 0., 1., 0., -2.0e-01, "
              "-1., 0., 0., 1.0e-01,\n       0., 0., 1., -3.0e-01, 0., 0., 0., 1. ]\n");
  chain = changed(chain, "T_cam_imu:", "T_cam_imu: !!opencv-matrix");
  std::string windows = "\xef\xbb\xbf%YAML:1.0\r\n---\r\n";
  for (const char c : chain) windows += c == '\n' ? "\r\n" : std::string(1, c);
  write(windows, "\xef\xbb\xbf" + kImu.substr(0, kImu.size() - 1));
  const KalibrCalibration k = read();
  EXPECT_EQ(k.cameras[0].cam_T_imu.R, rows.cam_T_imu.R);
  EXPECT_EQ(k.cameras[0].cam_T_imu.p, rows.cam_T_imu.p);
  EXPECT_EQ(k.camera_topics[0], "/cam0/image_raw");
}

TEST_F(Kalibr, HiddenFilesAreLeftOut) {
  for (const char* name : {"._camchain-imucam.yaml", "._imu.yaml", ".walk-imu.yaml"}) {
    test::spill(folder / name, "of macOS");
  }
  EXPECT_EQ(find_kalibr(folder)->cameras.filename(), "camchain-imucam.yaml");
  EXPECT_EQ(find_kalibr(folder)->imu.filename(), "imu.yaml");
  EXPECT_TRUE(find_kalibr(folder)->remarks.empty());
}

TEST_F(Kalibr, OnlyTheCamerasThatAreAskedForMustBeGood) {
  write(changed(kChain, "equidistant", "cubic"), kImu);
  expect_parts(error(), {"'cubic'"});
  EXPECT_EQ(read_kalibr(find_kalibr(folder).value(), 1).cameras.size(), 1u);
}

TEST_F(Kalibr, AnOffsetThatIsNoTimeIsRejected) {
  for (const char* offset : {".nan", "1e300", "-5e9", "[1]"}) {
    write(changed(kChain, "-0.0052", offset), kImu);
    expect_parts(error(), {"camchain-imucam.yaml:14", "timeshift_cam_imu"});
  }
  write(kChain, kImu + "time_offset: 0.1\n");
  expect_parts(error(), {"imu.yaml:7", "time_offset", "expected 0"});
}

TEST_F(Kalibr, TheResultComesBeforeTheInput) {
  std::string below = "imu0:\n";
  std::istringstream lines(changed(kImu, "4.0e-06", "5.0e-06"));
  for (std::string line; std::getline(lines, line);) below += "  " + line + "\n";
  test::spill(folder / "imu-walk.yaml", below);  // the older names
  EXPECT_EQ(read().imu_noise.gyroscope_random_walk, 5e-6);
  expect_parts(find_kalibr(folder)->remarks.at(0), {"imu-walk.yaml is read, and imu.yaml is not"});
  test::spill(folder / "camchain.yaml", "cam0:\n");  // of the cameras alone
  EXPECT_EQ(find_kalibr(folder)->cameras.filename(), "camchain-imucam.yaml");
  fs::rename(folder / "camchain-imucam.yaml", folder / "walk-camchain-imucam.yml");
  fs::rename(folder / "imu-walk.yaml", folder / "walk-imu.yaml");  // the newer names
  test::spill(folder / "other-imu.yaml", "");
  EXPECT_EQ(read().imu_noise.gyroscope_random_walk, 5e-6);
  EXPECT_EQ(find_kalibr(folder)->imu.filename(), "walk-imu.yaml");
  fs::remove(folder / "walk-imu.yaml");
  test::spill(folder / "third-imu.yaml", "");
  expect_parts(error(), {"other-imu.yaml and third-imu.yaml", "one of them"});
}

TEST_F(Kalibr, AChainOfCamerasWithExtrinsicsServes) {
  fs::rename(folder / "camchain-imucam.yaml", folder / "camchain.yaml");
  fs::rename(folder / "imu.yaml", folder / "imu_config.yaml");  // as in TUM-VI's dso/
  EXPECT_EQ(read().cameras.size(), 2u);
  test::spill(folder / "camchain.yaml", changed(kChain, "T_cam_imu", "T_none"));
  expect_parts(error(), {"camchain.yaml", "T_cam_imu': is missing", "kalibr_calibrate_imu_camera"});
}

TEST_F(Kalibr, FilesAreFoundByNameAndMustBeOneOfAKind) {
  test::spill(folder / "run2-camchain-imucam.yaml", kChain);
  expect_parts(error(), {"camchain-imucam.yaml and run2-camchain-imucam.yaml", "one of them"});
  fs::remove(folder / "camchain-imucam.yaml");
  EXPECT_EQ(read().cameras.size(), 2u);
  fs::remove(folder / "imu.yaml");
  expect_parts(error(), {"no imu.yaml beside run2-camchain-imucam.yaml"});
  fs::remove(folder / "run2-camchain-imucam.yaml");
  EXPECT_FALSE(find_kalibr(folder).has_value());
}

}  // namespace
}  // namespace chasles
