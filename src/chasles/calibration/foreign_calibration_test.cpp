#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/recording/apply_calibration.hpp>
#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/sensor_calibration.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

// Two cameras, 11 cm apart, and the IMU; the files below state them in other programs' ways.
const SE3 kImuTCam0{so3::exp({0.1, -0.2, 1.5}), {-0.02, -0.06, 0.01}};
const SE3 kImuTCam1{so3::exp({0.11, -0.19, 1.51}), {-0.02, 0.05, 0.01}};

std::string row_of(const SE3& T) {
  const Eigen::Matrix3d R = T.R;
  const Eigen::Vector3d p = T.p;
  std::string text;
  for (int i = 0; i < 3; ++i) {
    text += fmt::format("{}, {}, {}, {}, ", R(i, 0), R(i, 1), R(i, 2), p[i]);
  }
  return text + "0, 0, 0, 1";
}

std::string opencv_matrix(const std::string& data, int rows = 4, int cols = 4) {
  return fmt::format("!!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [{}]\n", rows,
                     cols, data);
}

const std::string kNoiseKeys = "acc_n: 0.2\ngyr_n: 0.02\nacc_w: 0.004\ngyr_w: 0.0002\n";
const std::string kOrbNoise =
    "IMU.NoiseGyro: 1.7e-04\nIMU.NoiseAcc: 2.0e-03\nIMU.GyroWalk: 1.9e-05\nIMU.AccWalk: 3.0e-03\n"
    "IMU.Frequency: 200.0\n";

std::string vins_text() {
  return "%YAML:1.0\n\nimu: 1\nnum_of_cam: 2\nimu_topic: \"/imu0\"\nimage0_topic: \"/a\"\n"
         "image1_topic: \"/b\"\ncam0_calib: \"left.yaml\"\ncam1_calib: \"right.yaml\"\n"
         "estimate_extrinsic: 0\nbody_T_cam0: " +
         opencv_matrix(row_of(kImuTCam0)) + "body_T_cam1: " + opencv_matrix(row_of(kImuTCam1)) +
         kNoiseKeys + "td: 0.005\n";
}

std::string vins_lens_text() {
  return "%YAML:1.0\n---\nmodel_type: PINHOLE\ncamera_name: camera\nimage_width: 752\n"
         "image_height: 480\ndistortion_parameters:\n   k1: -0.28\n   k2: 0.07\n   p1: 0.0002\n"
         "   p2: 0.00002\nprojection_parameters:\n   fx: 458\n   fy: 457\n   cx: 367\n   cy: 248\n";
}

std::string orb_lens_text(const std::string& camera) {
  std::string text;
  for (const char* value : {"fx: 458", "fy: 457", "cx: 367", "cy: 248", "k1: -0.28", "k2: 0.07",
                            "p1: 0.0002", "p2: 0.00002"}) {
    text += camera + "." + value + "\n";
  }
  return text;
}

std::string orb_text() {
  return "%YAML:1.0\n\nFile.version: \"1.0\"\nCamera.type: \"PinHole\"\n" +
         orb_lens_text("Camera1") + orb_lens_text("Camera2") +
         "Camera.width: 752\nCamera.height: 480\nStereo.T_c1_c2: " +
         opencv_matrix(row_of(kImuTCam0.inverse() * kImuTCam1)) +
         "IMU.T_b_c1: " + opencv_matrix(row_of(kImuTCam0)) + kOrbNoise;
}

std::string basalt_pose(const SE3& T) {
  const Eigen::Vector4d q = unit_quaternion(T.R);
  return fmt::format(R"({{"px":{},"py":{},"pz":{},"qx":{},"qy":{},"qz":{},"qw":{}}})", T.p.x(),
                     T.p.y(), T.p.z(), q[0], q[1], q[2], q[3]);
}

const char* const kBasaltLens =
    R"({"camera_type":"pinhole-radtan8","intrinsics":{"fx":458,"fy":457,"cx":367,"cy":248,)"
    R"("k1":-0.28,"k2":0.07,"p1":0.0002,"p2":0.00002,"k3":0,"k4":0,"k5":0,"k6":0,"rpmax":0}})";

std::string basalt_text(const std::string& lens = kBasaltLens,
                        const std::string& accelerometer = "0,0,0,0,0,0,0,0,0") {
  return fmt::format(
      R"({{"value0":{{"T_imu_cam":[{},{}],"intrinsics":[{},{}],"resolution":[[752,480],[752,480]],)"
      R"("calib_accel_bias":[{}],"calib_gyro_bias":[0,0,0,0,0,0,0,0,0,0,0,0],"imu_update_rate":200,)"
      R"("accel_noise_std":[0.016,0.016,0.017],"gyro_noise_std":[0.0003,0.0003,0.0003],)"
      R"("accel_bias_std":[0.001,0.001,0.001],"gyro_bias_std":[0.0001,0.0001,0.0001],)"
      R"("cam_time_offset_ns":2000000,"vignette":[]}}}})",
      basalt_pose(kImuTCam0), basalt_pose(kImuTCam1), lens, lens, accelerometer);
}

std::string depthai_entry(int socket, int to, const SE3& to_T_from, const std::string& more) {
  const Eigen::Matrix3d R = to_T_from.R;
  const Eigen::Vector3d t = 100 * to_T_from.p;  // [cm]
  return fmt::format(
      R"([{},{{"cameraType":0,"distortionCoeff":[-0.28,0.07,0.0002,0.00002,0{}],"extrinsics":)"
      R"({{"rotationMatrix":[[{},{},{}],[{},{},{}],[{},{},{}]],"toCameraSocket":{},"translation":)"
      R"({{"x":{},"y":{},"z":{}}}}},"width":752,"height":480,)"
      R"("intrinsicMatrix":[[458,0,367],[0,457,248],[0,0,1]]}}])",
      socket, more, R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2),
      to, t.x(), t.y(), t.z());
}

// The left camera (1) leads to the right one (2), and so does the IMU.
std::string depthai_text(const std::string& more = ",0,0,0", int imu_to = 2) {
  const SE3 right_T_imu = kImuTCam1.inverse();
  const std::string imu = depthai_entry(9, imu_to, right_T_imu, "");
  const std::size_t begin = imu.find("\"extrinsics\":") + 13, end = imu.find(",\"width\"");
  return "{\"cameraData\":[" + depthai_entry(2, -1, SE3{}, more) + "," +
         depthai_entry(1, 2, right_T_imu * kImuTCam0, more) +
         "],\"imuExtrinsics\":" + imu.substr(begin, end - begin) + "}";
}

const std::string kNoiseFile =
    "accelerometer_noise_density: 2.0e-3\naccelerometer_random_walk: 3.0e-3\n"
    "gyroscope_noise_density: 1.7e-4\ngyroscope_random_walk: 1.9e-5\n";

class ForeignCalibration : public ::testing::Test {
 protected:
  void SetUp() override { folder = test::scratch(); }
  void add(const std::string& name, const std::string& text) const {
    fs::create_directories((folder / name).parent_path());
    test::spill(folder / name, text);
  }
  void add_vins(const std::string& text) const {
    add("config.yaml", text);
    add("left.yaml", vins_lens_text());
    add("right.yaml", vins_lens_text());
  }
  KalibrCalibration read() const { return find_calibration({folder}).value(); }
  std::string error() const {
    return input_error([&] { find_calibration({folder}); });
  }
  static std::string changed(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }
  static void expect_rig(const KalibrCalibration& rig, std::size_t cameras = 2,
                         double accuracy = 1e-12) {
    ASSERT_EQ(rig.cameras.size(), cameras);
    ASSERT_EQ(rig.time_offsets.size(), cameras);
    ASSERT_EQ(rig.camera_topics.size(), cameras);
    for (std::size_t c = 0; c < cameras; ++c) {
      const Camera& camera = rig.cameras[c];
      const SE3 error = camera.cam_T_imu * (c == 0 ? kImuTCam0 : kImuTCam1);
      EXPECT_TRUE(error.R.isIdentity(accuracy)) << "cam" << c;
      EXPECT_TRUE(error.p.isZero(accuracy)) << "cam" << c;
      EXPECT_EQ(camera.width, 752);
      EXPECT_EQ(camera.height, 480);
      EXPECT_EQ(camera.fx, 458);
      EXPECT_EQ(camera.cy, 248);
      EXPECT_EQ(camera.distortion, Distortion::kRadtan);
      EXPECT_EQ(camera.coefficients, (LensCoefficients{-0.28, 0.07, 0.0002, 0.00002}));
    }
  }
  fs::path folder;
};

// VINS takes the stamp of an image for the time of its middle row.
TEST_F(ForeignCalibration, OfVinsWithARollingShutter) {
  add_vins(vins_text() + "rolling_shutter: 1\nrolling_shutter_tr: 0.030\n");
  const KalibrCalibration rig = read();
  EXPECT_EQ(rig.cameras.at(0).shutter.readout, 0.03);
  EXPECT_EQ(rig.cameras.at(0).shutter.direction, ReadoutDirection::kDown);
  EXPECT_EQ(rig.time_offsets.at(0), std::chrono::milliseconds(5 - 15));
  add_vins(vins_text() + "rolling_shutter: 0\nrolling_shutter_tr: 0.030\n");
  EXPECT_FALSE(read().cameras.at(0).shutter.is_rolling());
  EXPECT_EQ(read().time_offsets.at(0), std::chrono::milliseconds(5));
  add_vins(vins_text() + "rolling_shutter: 1\nrolling_shutter_tr: 30\n");
  expect_parts(error(), {"config.yaml", "rolling_shutter_tr", "is 30", "in seconds"});
}

TEST_F(ForeignCalibration, OfVinsFusion) {
  add_vins(vins_text());
  const KalibrCalibration rig = read();
  expect_rig(rig);
  EXPECT_EQ(rig.imu_topic, "/imu0");
  EXPECT_EQ(rig.camera_topics[1], "/b");
  EXPECT_EQ(rig.time_offsets[1], std::chrono::milliseconds(5));
  expect_parts(rig.remarks.at(0), {"config.yaml (VINS)"});
  add("config.yaml", changed(vins_text(), "estimate_extrinsic: 0", "estimate_extrinsic: 2"));
  expect_parts(error(), {"config.yaml:10", "estimate_extrinsic", "not known"});
  add("config.yaml", changed(vins_text(), "gyr_w", "gyr_walk"));
  expect_parts(error(), {"config.yaml", "'gyr_w' is missing"});
  add("config.yaml", changed(vins_text(), "imu: 1", "imu: 0"));
  expect_parts(error(), {"has no IMU"});
  add_vins(vins_text());
  fs::remove(folder / "right.yaml");
  expect_parts(error(), {"cam1_calib", "right.yaml", "not there"});
  add("right.yaml", changed(vins_lens_text(), "PINHOLE", "SCARAMUZZA"));
  expect_parts(error(), {"right.yaml:3", "SCARAMUZZA", "PINHOLE, KANNALA_BRANDT or MEI"});
  add("right.yaml", changed(vins_lens_text(), "PINHOLE", "MEI"));
  expect_parts(error(), {"right.yaml", "gamma1"});
  add("right.yaml",
      "%YAML:1.0\n---\nmodel_type: MEI\nimage_width: 752\nimage_height: 480\n"
      "mirror_parameters:\n   xi: 1.6\ndistortion_parameters:\n   k1: -0.1\n   k2: 0.2\n"
      "   p1: 0.003\n   p2: -0.004\nprojection_parameters:\n   gamma1: 800\n   gamma2: 801\n"
      "   u0: 367\n   v0: 248\n");
  EXPECT_EQ(read().cameras[1].distortion, Distortion::kOmni);
  EXPECT_EQ(read().cameras[1].coefficients, (LensCoefficients{1.6, -0.1, 0.2, 0.003, -0.004}));
  EXPECT_EQ(read().cameras[1].fy, 801);
}

TEST_F(ForeignCalibration, OfVinsMonoWithAFisheyeLens) {
  std::string R, p;
  for (int i = 0; i < 9; ++i) R += fmt::format("{}{}", i ? ", " : "", kImuTCam0.R(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) p += fmt::format("{}{}", i ? ", " : "", kImuTCam0.p[i]);
  add("config.yaml",
      "%YAML:1.0\nimu_topic: \"/imu0\"\nimage_topic: \"/a\"\nmodel_type: KANNALA_BRANDT\n"
      "image_width: 752\nimage_height: 480\nprojection_parameters:\n   k2: 0.1\n   k3: 0.2\n"
      "   k4: 0.3\n   k5: 0.4\n   mu: 458\n   mv: 457\n   u0: 367\n   v0: 248\n"
      "extrinsicRotation: " +
          opencv_matrix(R, 3, 3) + "extrinsicTranslation: " + opencv_matrix(p, 3, 1) + kNoiseKeys);
  const KalibrCalibration rig = read();
  ASSERT_EQ(rig.cameras.size(), 1u);
  EXPECT_EQ(rig.cameras[0].distortion, Distortion::kEquidistant);
  EXPECT_EQ(rig.cameras[0].coefficients, (LensCoefficients{0.1, 0.2, 0.3, 0.4}));
  EXPECT_EQ(rig.cameras[0].cx, 367);
  EXPECT_EQ(rig.camera_topics[0], "/a");
  EXPECT_TRUE((rig.cameras[0].cam_T_imu * kImuTCam0).p.isZero(1e-12));
}

// The white noise of samples at 200 Hz, added up over a second, is that of the density.
TEST_F(ForeignCalibration, TheNoiseOfSamplesBecomesThatOfDensities) {
  add_vins(vins_text());
  const KalibrCalibration rig = read();
  ASSERT_TRUE(rig.noise_of_samples);
  Recording recording;
  take_kalibr(rig, recording);
  for (int i = 0; i <= 200; ++i)
    recording.imu.push_back({.time = i * std::chrono::milliseconds(5)});
  take_noise_of_samples(rig, recording);
  const double of_a_second = std::sqrt(200 * std::pow(0.2 * 0.005, 2));  // velocity [m/s]
  const double walk_of_a_second = std::sqrt(200 * std::pow(0.004 * 0.005, 2));
  EXPECT_NEAR(recording.imu_noise->accelerometer_noise_density, of_a_second, 1e-9);
  EXPECT_NEAR(recording.imu_noise->accelerometer_random_walk, walk_of_a_second, 1e-9);
  EXPECT_NEAR(recording.imu_noise->gyroscope_noise_density, of_a_second / 10, 1e-9);
  expect_parts(recording.remarks.back(), {"stated for a sample", "200 Hz"});
  expect_parts(input_error([&] { read_sensor_calibration(folder); }),
               {"VINS", "rate of the samples is not known"});
}

TEST_F(ForeignCalibration, OfOrbSlam3ByNewAndOldNames) {
  add("walk.yaml", orb_text());
  expect_rig(read());
  EXPECT_EQ(read().imu_noise.accelerometer_random_walk, 3e-3);
  EXPECT_EQ(read_sensor_calibration(folder).cameras.size(), 2u);
  std::string old = changed(orb_text(), "IMU.T_b_c1", "Tbc");
  for (std::size_t at = 0; (at = old.find("Camera1.")) != std::string::npos;) old.erase(at + 6, 1);
  const std::string c1_T_c2 = row_of(kImuTCam0.inverse() * kImuTCam1);
  old = changed(old, "Stereo.T_c1_c2: " + opencv_matrix(c1_T_c2),
                "Tlr: " + opencv_matrix(c1_T_c2.substr(0, c1_T_c2.size() - 12), 3, 4));
  add("walk.yaml", old);
  expect_rig(read());
  std::string single = orb_text();
  single.erase(single.find("Stereo.T_c1_c2"), single.find("IMU.T_b_c1") - single.find("Stereo."));
  for (std::size_t at = 0; (at = single.find("Camera2.")) != std::string::npos;) {
    single.erase(at, single.find('\n', at) + 1 - at);
  }
  add("walk.yaml", single);
  expect_rig(read(), 1);
  add("walk.yaml", changed(orb_text(), "IMU.T_b_c1", "IMU.T_b_c9"));
  expect_parts(error(), {"walk.yaml", "'IMU.T_b_c1'", "Tbc", "without an IMU"});
  add("walk.yaml", changed(orb_text(), "IMU.NoiseAcc", "IMU.Noise"));
  expect_parts(error(), {"'IMU.NoiseAcc' is missing"});
}

// Old stereo files have the lenses before rectification, and its rotations.
TEST_F(ForeignCalibration, OfOrbSlam3BeforeRectification) {
  const SE3 c1_T_c2 = kImuTCam0.inverse() * kImuTCam1;
  const Eigen::Vector3d x = c1_T_c2.p.normalized();
  Eigen::Matrix3d rect_R_c1;
  rect_R_c1.row(0) = x;
  rect_R_c1.row(1) = Eigen::Vector3d(0, 0, 1).cross(x).normalized();
  rect_R_c1.row(2) = x.cross(Eigen::Vector3d(rect_R_c1.row(1)));
  const Eigen::Matrix3d rect_R_c2 = rect_R_c1 * c1_T_c2.R;
  const auto list = [](const Eigen::Matrix3d& M) {
    std::string text;
    for (int i = 0; i < 9; ++i) text += fmt::format("{}{}", i ? ", " : "", M(i / 3, i % 3));
    return text;
  };
  std::string text =
      "%YAML:1.0\nCamera.fx: 435\nCamera.fy: 435\nCamera.cx: 367\nCamera.cy: 252\n"
      "Camera.width: 752\nCamera.height: 480\nCamera.bf: 47.9\nTbc: " +
      opencv_matrix(row_of(kImuTCam0)) + kOrbNoise;
  for (const char* side : {"LEFT", "RIGHT"}) {
    const bool left = std::string(side) == "LEFT";
    text += fmt::format("{0}.height: 480\n{0}.width: 752\n{0}.D: {1}{0}.K: {2}{0}.R: {3}{0}.P: {4}",
                        side, opencv_matrix("-0.28, 0.07, 0.0002, 0.00002, 0", 1, 5),
                        opencv_matrix("458, 0, 367, 0, 457, 248, 0, 0, 1", 3, 3),
                        opencv_matrix(list(left ? rect_R_c1 : rect_R_c2), 3, 3),
                        opencv_matrix(fmt::format("435, 0, 367, {}, 0, 435, 252, 0, 0, 0, 1, 0",
                                                  left ? 0 : -435 * c1_T_c2.p.norm()),
                                      3, 4));
  }
  add("walk.yaml", text);
  expect_rig(read(), 2, 1e-9);
}

TEST_F(ForeignCalibration, OfBasalt) {
  add("calibration.json", basalt_text());
  const KalibrCalibration rig = read();
  expect_rig(rig);
  EXPECT_EQ(rig.time_offsets[0], std::chrono::milliseconds(2));
  EXPECT_EQ(rig.imu_noise.accelerometer_noise_density, 0.017);  // the largest of three axes
  EXPECT_FALSE(rig.imu_intrinsics.has_value());
  add("calibration.json", changed(basalt_text(), "gyro_noise_std", "gyro_noise"));
  expect_parts(error(), {"calibration.json: value0 'gyro_noise_std' is missing"});
  add("calibration.json", basalt_text(changed(kBasaltLens, "\"k5\":0", "\"k5\":0.3")));
  EXPECT_EQ(read().cameras[0].coefficients[6], 0.3);
  EXPECT_EQ(read().cameras[0].coefficients.size(), 8u);
  add("calibration.json", basalt_text(changed(kBasaltLens, "pinhole-radtan8", "cubic")));
  expect_parts(error(), {"camera_type is cubic", "kb4"});
  add("calibration.json", basalt_text(changed(kBasaltLens, "pinhole-radtan8", "ds")));
  expect_parts(error(), {"intrinsics[0].intrinsics 'xi' is missing"});
  add("calibration.json",
      basalt_text(R"({"camera_type":"kb4","intrinsics":{"fx":458,"fy":457,"cx":367,"cy":248,)"
                  R"("k1":0.1,"k2":0.2,"k3":0.3,"k4":0.4}})"));
  EXPECT_EQ(read().cameras[1].distortion, Distortion::kEquidistant);
  EXPECT_EQ(read().cameras[1].coefficients, (LensCoefficients{0.1, 0.2, 0.3, 0.4}));
  struct Model {
    std::string name, values;
    Distortion distortion;
    LensCoefficients coefficients;
  };
  for (const auto& [name, values, distortion, coefficients] : std::vector<Model>{
           {"ds", R"("alpha":0.6,"xi":-0.2)", Distortion::kDoubleSphere, {-0.2, 0.6}},
           {"eucm", R"("alpha":0.6,"beta":1.1)", Distortion::kEucm, {0.6, 1.1}},
           {"ucm", R"("alpha":0.6)", Distortion::kEucm, {0.6, 1}},
           {"fov", R"("w":0.9)", Distortion::kFov, {0.9}},
           {"pinhole", R"("w":0.9)", Distortion::kNone, {}}}) {
    add("calibration.json",
        basalt_text(R"({"camera_type":")" + name +
                    R"(","intrinsics":{"fx":458,"fy":457,"cx":367,"cy":248,)" + values + "}}"));
    EXPECT_EQ(read().cameras[1].distortion, distortion) << name;
    EXPECT_EQ(read().cameras[1].coefficients, coefficients) << name;
  }
  add("calibration.json",
      basalt_text(R"({"camera_type":"ds","intrinsics":{"fx":458,"fy":457,"cx":367,"cy":248,)"
                  R"("xi":-0.2,"alpha":1.2}})"));
  expect_parts(error(), {"intrinsics[0].intrinsics", "alpha from 0 to 1"});
}

// f = (I + S) f_m - b, with S lower triangular and stored by columns.
TEST_F(ForeignCalibration, OfBasaltWithABiasAndScales) {
  add("calibration.json", basalt_text(kBasaltLens, "0.1,0.2,0.3,0.01,0.02,0.03,0.04,0.05,0.06"));
  const KalibrCalibration rig = read();
  ASSERT_TRUE(rig.imu_intrinsics.has_value());
  Eigen::Matrix3d S;
  S << 0.01, 0, 0, 0.02, 0.04, 0, 0.03, 0.05, 0.06;
  const Eigen::Vector3d measured(1, -2, 9),
      expected = measured + S * measured - Eigen::Vector3d(0.1, 0.2, 0.3);
  const ImuSample sample = corrected(*rig.imu_intrinsics, {}, {.specific_force_imu = measured});
  EXPECT_TRUE(sample.specific_force_imu.isApprox(expected, 1e-14));
  EXPECT_TRUE(sample.angular_rate_imu.isZero(0));
}

TEST_F(ForeignCalibration, OfDepthai) {
  add("calib.json", depthai_text());
  expect_parts(error(), {"calib.json", "depthai", "no noise", "imu.yaml"});
  add("imu.yaml", kNoiseFile);
  const KalibrCalibration rig = read();
  expect_rig(rig, 2, 1e-9);
  EXPECT_EQ(rig.imu_noise.gyroscope_random_walk, 1.9e-5);
  expect_parts(rig.remarks.back(), {"calib.json (depthai", "imu.yaml"});
  add("calib.json", depthai_text(",0.5,0,0"));
  EXPECT_EQ(read().cameras[0].coefficients.size(), 8u);
  EXPECT_EQ(read().cameras[0].coefficients[5], 0.5);
  add("calib.json", depthai_text(",0,0,0,0,0,0,0,0.1,0"));
  expect_parts(error(), {"calib.json", "14 coefficients", "tilted sensor"});
  const std::string stereo =
      R"(,"stereoRectificationData":{"leftCameraSocket":1,"rightCameraSocket":2}})";
  std::string pair = depthai_text();
  add("calib.json", pair.substr(0, pair.size() - 1) + stereo);
  expect_rig(read(), 2, 1e-9);
  pair = changed(stereo, "\"rightCameraSocket\":2", "\"rightCameraSocket\":4");
  add("calib.json", depthai_text().substr(0, depthai_text().size() - 1) + pair);
  expect_parts(error(), {"'cameraData' has no camera at socket 4"});
  add("calib.json", depthai_text(",0,0,0", -1));
  expect_parts(error(), {"'imuExtrinsics' is missing", "kalibr_calibrate_imu_camera"});
}

// Zeros for them, or one camera instead of two, would be a wrong calibration without a word.
TEST_F(ForeignCalibration, ValuesThatAreMissingAreNamed) {
  const auto without = [](std::string text, const std::string& key, std::size_t from = 0) {
    const std::size_t at = text.find(key, from);
    EXPECT_NE(at, std::string::npos) << key;
    return text.insert(at + key.size(), "_");
  };
  add_vins(vins_text());
  for (const char* key : {"k1", "k2", "p1", "p2", "fx", "fy", "cx", "cy"}) {
    add("right.yaml", without(vins_lens_text(), key));
    expect_parts(error(), {"right.yaml", fmt::format("'{}' is missing", key)});
  }
  add_vins(changed(without(vins_text(), "body_T_cam1"), "num_of_cam: 2\n", ""));
  expect_parts(error(), {"config.yaml", "'body_T_cam1' is missing"});
  add_vins(changed(without(vins_text(), "cam1_calib"), "num_of_cam: 2\n", ""));
  expect_parts(error(), {"config.yaml", "'cam1_calib' is missing"});
  for (const char* name : {"config.yaml", "left.yaml", "right.yaml"}) fs::remove(folder / name);
  for (const char* key : {"Camera1.fx", "Camera1.cy", "Camera1.k1", "Camera1.k2", "Camera1.p2",
                          "Camera2.fx", "Camera2.k1", "Stereo.T_c1_c2"}) {
    add("walk.yaml", without(orb_text(), key));
    expect_parts(error(), {"walk.yaml", fmt::format("'{}' is missing", key)});
  }
  fs::remove(folder / "walk.yaml");
  for (const char* key : {"fx", "k1", "k3", "k6", "p2"}) {
    add("calibration.json", basalt_text(without(kBasaltLens, key)));
    expect_parts(error(), {"calibration.json", fmt::format("'{}' is missing", key)});
  }
  for (const char* key : {"resolution", "calib_accel_bias", "calib_gyro_bias"}) {
    add("calibration.json", without(basalt_text(), key));
    expect_parts(error(), {"calibration.json", fmt::format("'{}' is missing", key)});
  }
  add("calibration.json", changed(basalt_text(), "[[752,480],[752,480]]", "[[752,480]]"));
  expect_parts(error(), {"T_imu_cam: has 2 poses", "2 lenses", "1 sizes"});
}

TEST_F(ForeignCalibration, ValuesThatAreOptionalThereMayBeMissing) {
  add_vins(changed(vins_text(), "td: 0.005\n", ""));
  EXPECT_EQ(read().time_offsets[1], Time{});
  const std::string lens = vins_lens_text();
  const std::size_t begin = lens.find("distortion_parameters"), end = lens.find("projection");
  add("left.yaml", lens.substr(0, begin) + lens.substr(end));
  EXPECT_EQ(read().cameras[0].distortion, Distortion::kNone);
  expect_parts(read().remarks.at(0), {"left.yaml", "'distortion_parameters' is missing"});
  for (const char* name : {"config.yaml", "left.yaml", "right.yaml"}) fs::remove(folder / name);
  std::string none = orb_text();
  for (const char* key : {"Camera1.k1", "Camera1.k2", "Camera1.p1", "Camera1.p2"}) {
    none = changed(none, key, std::string(key) + "_");
  }
  add("walk.yaml", none);
  EXPECT_EQ(read().cameras[0].distortion, Distortion::kNone);
  EXPECT_EQ(read().cameras[1].distortion, Distortion::kRadtan);
  add("walk.yaml", orb_text() + "Camera2.k3: 0.25\n");
  EXPECT_EQ(read().cameras[0].coefficients.size(), 4u);
  EXPECT_EQ(read().cameras[1].coefficients[4], 0.25);
}

TEST_F(ForeignCalibration, AFileOfTheImuBesideItIsNamed) {
  add("imu.yaml", kNoiseFile);
  add("config/walk.yaml", orb_text());
  const KalibrCalibration rig = read();
  EXPECT_EQ(rig.imu_noise.accelerometer_random_walk, 3e-3);
  expect_parts(rig.remarks.back(), {"imu.yaml is not read", "that of walk.yaml"});
}

TEST_F(ForeignCalibration, TheFirstPlaceCountsAndKalibrComesFirst) {
  add("notes.json", "{\"cameras\": 2}");
  add("rviz.yaml", "Panels: none\n");
  EXPECT_FALSE(find_calibration({folder}).has_value());
  add("config/walk.yaml", orb_text());
  expect_rig(read());
  add("calibration.json", basalt_text());
  EXPECT_EQ(read().time_offsets[0], std::chrono::milliseconds(2));  // in the folder itself
  add("walk.yaml", orb_text());
  expect_parts(error(), {"both calibration.json and walk.yaml", "expected one"});
  add("config/kalibr_imucam_chain_X3.yaml",
      "cam0:\n  T_imu_cam: " + ("[" + row_of(kImuTCam0) + "]") +
          "\n  camera_model: pinhole\n  distortion_coeffs: [-0.28, 0.07, 0.0002, 0.00002]\n"
          "  distortion_model: radtan\n  intrinsics: [458, 457, 367, 248]\n"
          "  resolution: [752, 480]\n");
  add("config/kalibr_imu_chain_X3.yaml", "imu0:\n  " + changed(kNoiseFile, "\n", "\n  "));
  expect_parts(error(), {"kalibr_imu_chain_X3.yaml"});  // its second key is out of line
  std::string noise = "imu0:\n";
  std::istringstream lines(kNoiseFile);
  for (std::string line; std::getline(lines, line);) noise += "  " + line + "\n";
  add("config/kalibr_imu_chain_X3.yaml", noise);
  add("config/kalibr_imu_chain_Y.yaml", "");  // of another camera chain
  expect_rig(read(), 1);
}

TEST_F(ForeignCalibration, AReportOfKalibrIsNamed) {
  add("walk-results-imucam.txt", "Calibration results\n");
  EXPECT_FALSE(find_calibration({folder}).has_value());
  expect_parts(insufficient_calibration({folder}),
               {"walk-results-imucam.txt", "camchain-imucam.yaml"});
}

// A headset's recording: EuRoC's tables without sensor.yaml, and without a comment in data.csv.
TEST_F(ForeignCalibration, ServesAnEurocFolder) {
  test::write_euroc_folder(folder / "rec", 2);
  for (const char* sensor : {"cam0", "cam1", "imu0"}) {
    fs::remove(folder / "rec/mav0" / sensor / "sensor.yaml");
  }
  expect_parts(input_error([&] { read_recording(folder / "rec"); }), {"Basalt"});
  std::string text = basalt_text();
  for (std::size_t at = 0; (at = text.find("[752,480]")) != std::string::npos;) {
    text.replace(at, 9, "[8,6]");
  }
  add("rec/calibration.json", text);
  test::spill(folder / "rec/mav0/cam1/data.csv",
              "timestamp,filename\n5000000,5000000.png\n10000000,10000000.png\n");
  const Recording r = read_recording(folder / "rec");
  EXPECT_EQ(r.cameras.size(), 2u);
  EXPECT_EQ(r.images->time(0), std::chrono::milliseconds(7));  // with the time offset
  EXPECT_EQ(r.imu_noise->gyroscope_noise_density, 0.0003);
}

}  // namespace
}  // namespace chasles
