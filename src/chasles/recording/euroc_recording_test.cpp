#include <algorithm>

#include <fmt/format.h>

#include <chasles/camera/camera.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/recording/inertial_testing.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

std::string joined_remarks(const std::vector<std::string>& lines) {
  return fmt::format("{}", fmt::join(lines, "\n"));
}

const Eigen::Vector3d kUp = Eigen::Vector3d(0.3, 0.9, -0.1).normalized();

std::string csv(const Eigen::VectorXd& values) {
  return fmt::format("{}", fmt::join(values.begin(), values.end(), ","));
}

const char* const kCameraYaml =
    "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n"
    "  data: [0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]\n"
    "resolution: [752, 480]\ncamera_model: pinhole\nintrinsics: [458, 457, 367, 248] #fu\n"
    "distortion_model: radial-tangential\ndistortion_coefficients: [-0.28, 0.07, 1e-4, 2e-5]\n";
const char* const kImuYaml =
    "sensor_type: imu\nT_BS:\n  cols: 4\n  rows: 4\n"
    "  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nrate_hz: 200\n"
    "gyroscope_noise_density: 1e-4\ngyroscope_random_walk: 2e-5\n"
    "accelerometer_noise_density: 2e-3\naccelerometer_random_walk: 3e-3\n";

/// A small recording of the same kind, in a world whose up direction is kUp.
class AprilFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = test::scratch() / "board";
    fs::create_directories(folder);
    test::spill(folder / "cam0_sensor.yaml", kCameraYaml);
    test::spill(folder / "cam1_sensor.yaml", kCameraYaml);
    test::spill(folder / "imu0_sensor.yaml", kImuYaml);
    std::string imu = "#ts,wx,wy,wz,ax,ay,az\n", tracks =
                                                     "#timestamp [ns],cam,corner_id(=4*tag),u"
                                                     " [px],v [px]\n";
    std::string poses =
        "#timestamp [ns],p_WB_x [m],p_WB_y,p_WB_z,q_WB_w,q_WB_x,q_WB_y,q_WB_z,n_corners,rms_px   "
        "(W = board, B = IMU; PnP)\n";
    for (const ImuSample& s : truth.imu) {
      imu += fmt::format("{},{},{}\n", s.time.count(), csv(s.angular_rate_imu),
                         csv(s.specific_force_imu));
    }
    for (std::size_t k = 0; k < truth.truth.size(); ++k) {
      const Eigen::Vector4d q = unit_quaternion(truth.truth[k].pose.R);
      const auto time = truth.truth[k].time.count();
      poses += fmt::format("{},{},{},{},{},{},{},0.3\n", time, csv(truth.truth[k].pose.p), q[3],
                           q[0], q[1], q[2], k == 7 ? 63 : 64);
      tracks += fmt::format("{0},0,5,10.5,20\n{0},1,5,9,20\n{0},1,6,9,20\n", time);
    }
    test::spill(folder / "imu0.csv", imu);
    test::spill(folder / "tracks.csv", tracks);
    test::spill(folder / "gt_pnp.csv", poses);
    test::spill(folder / "landmarks.csv",
                "#corner_id,x [m],y [m],z [m]  (board)\n5,1,0,0\n6,0,1,0\n");
  }
  // Replaces the first occurrence for one read and returns the error message.
  std::string error(const std::string& file, const std::string& from, const std::string& to) {
    const std::string text = test::slurp(folder / file);
    std::string changed = text;
    const std::size_t at = changed.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    test::spill(folder / file, changed.replace(at, from.size(), to));
    const std::string message = input_error([&] { read_recording(folder); });
    test::spill(folder / file, text);
    return message;
  }

  Recording truth = test::swung(-kStandardGravity * kUp, 8);
  fs::path folder;
};

TEST_F(AprilFolder, IsRecognisedAndReadWhole) {
  const Recording r = read_recording(folder);
  EXPECT_EQ(r.name, "board");
  EXPECT_EQ(read_recording(folder / "").name, "board");
  ASSERT_EQ(r.cameras.size(), 2u);
  EXPECT_EQ(r.cameras[0].distortion, Distortion::kRadtan);
  // T_BS maps camera to body: the camera is at (0.1, 0.2, 0.3).
  EXPECT_LT((r.cameras[0].cam_T_imu * Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-15);
  EXPECT_EQ(r.imu_noise->gyroscope_random_walk, 2e-5);
  EXPECT_EQ(r.imu_noise->accelerometer_noise_density, 2e-3);
  ASSERT_EQ(r.imu.size(), truth.imu.size());
  EXPECT_EQ(r.imu[100].specific_force_imu, truth.imu[100].specific_force_imu);
  EXPECT_EQ(r.imu[100].angular_rate_imu, truth.imu[100].angular_rate_imu);
  ASSERT_EQ(r.frames.size(), truth.truth.size());
  ASSERT_EQ(r.frames[3].pixels.size(), 3u);
  EXPECT_EQ(r.frames[3].pixels[0].pixel, Eigen::Vector2d(10.5, 20));
  EXPECT_EQ(r.frames[3].pixels[2].landmark, 6);
  EXPECT_EQ(r.frames[3].pixels[2].camera, 1);
}

TEST_F(AprilFolder, TruthAndLandmarksAreTurnedSoThatZPointsUp) {
  const Recording r = read_recording(folder);
  ASSERT_EQ(r.truth.size(), truth.truth.size() - 1) << "one pose uses 63 corners";
  EXPECT_NE(r.truth[7].time, truth.truth[7].time);
  // Both were rotated by the same rotation, which maps up to z.
  const Eigen::Matrix3d turn = r.truth[0].pose.R * truth.truth[0].pose.R.transpose();
  EXPECT_LT((turn * kUp - Eigen::Vector3d::UnitZ()).norm(), 2e-3);
  EXPECT_LT((turn * truth.truth[3].pose.p - r.truth[3].pose.p).norm(), 1e-12);
  EXPECT_LT((turn.col(0) - r.true_landmarks[0].p_world).norm(), 1e-12);
  EXPECT_LT((turn.col(1) - r.true_landmarks[1].p_world).norm(), 1e-12);
  expect_parts(joined_remarks(r.remarks), {"turned so that z points up", "1 of 160 poses"});
}

TEST_F(AprilFolder, AnOutageAndFramesOutsideTheSamplesAreReported) {
  std::string tracks = test::slurp(folder / "tracks.csv");
  const std::size_t from = tracks.find("\n1025000000,"), to = tracks.find("\n2025000000,");
  tracks.erase(from, to - from);
  test::spill(folder / "tracks.csv", tracks + "8001000000,0,5,1,2\n");
  expect_parts(joined_remarks(read_recording(folder).remarks),
               {"no frame for 1.05 s, from 0.95 s on", "1 of 141 frames are before the first"});
}

TEST_F(AprilFolder, WithoutTruthItIsStillARecording) {
  fs::remove(folder / "gt_pnp.csv");
  const Recording r = read_recording(folder);
  EXPECT_TRUE(r.truth.empty());
  EXPECT_TRUE(r.true_landmarks.empty()) << "the vertical is unknown";
  EXPECT_EQ(r.frames.size(), 160u);
}

TEST_F(AprilFolder, ItsTablesAreChecked) {
  expect_parts(error("imu0.csv", "#ts,wx,wy,wz,ax", "#ts,wx,wy,wz,wx"),
               {"imu0.csv:1: both wx and wx may be the angular rate"});
  expect_parts(error("imu0.csv", "#ts", "#when"), {"imu0.csv:1: has the columns when,wx"});
  expect_parts(error("imu0.csv", "\n5000000,", "\n9000000000000000000,"),
               {"imu0.csv:3: column 'ts'", "expected nanoseconds below 4600000000000000000"});
  expect_parts(error("imu0.csv", "\n5000000,", "\n5000000,nan,"), {"imu0.csv:3: has 8 values"});
  expect_parts(error("tracks.csv", "\n25000000,1,5,", "\n25000000,2,5,"),
               {"tracks.csv:3: column 'cam': there is no camera 2, expected 0 to 1"});
  expect_parts(error("tracks.csv", "\n25000000,1,6,", "\n25000000,1,5,"),
               {"tracks.csv:4: column 'corner_id': corner 5 is there twice in camera 1"});
  expect_parts(error("tracks.csv", "\n75000000,0,", "\n5000000,0,"),
               {"tracks.csv:5: column 'timestamp'", "rise strictly"});
  expect_parts(error("tracks.csv", "10.5", "inf"), {"tracks.csv:2: column 'u': found 'inf'"});
  expect_parts(error("gt_pnp.csv", "q_WB_w,q_WB_x", "q_WB_x,q_WB_w"), {"gt_pnp.csv:1: has the"});
  expect_parts(error("gt_pnp.csv", ",64,0.3\n", ",sixty,0.3\n"), {"column 'n_corners'"});
  expect_parts(error("landmarks.csv", "6,0,1,0", "6,0,1"), {"landmarks.csv:3: has 3 values"});
}

TEST_F(AprilFolder, ItsSensorsAreChecked) {
  const std::string cam = "cam1_sensor.yaml", imu = "imu0_sensor.yaml";
  expect_parts(error(cam, "radial-tangential", "cubic"),
               {"cam1_sensor.yaml:9: key 'distortion_model': 'cubic' is a model that is not supp"});
  expect_parts(error(cam, "data: [0, -1,", "data: [0, 1,"), {"'T_BS'", "reflection"});
  for (const char* width : {"[0.5,", "[1e300,"}) {
    expect_parts(error(cam, "resolution: [752,", std::string("resolution: ") + width),
                 {"'resolution'", "whole number of pixels"});
  }
  expect_parts(error(cam, "0, 0, 0, 1]", "0, 0, 1]"), {"'T_BS': expected 4 rows of 4 numbers"});
  expect_parts(error(cam, "camera_model: pinhole\n", ""), {"key 'camera_model' is missing"});
  expect_parts(error(cam, "type: camera", "type: imu"), {"'sensor_type': is 'imu', expected"});
  expect_parts(error(cam, "pinhole\n", "pinhole\ntimeshift_cam_imu: 0.01\n"),
               {"cam1_sensor.yaml", "timeshift_cam_imu", "0.01 s", "images only"});
  expect_parts(error(imu, "data: [1, 0, 0, 0,", "data: [1, 0, 0, 0.1,"), {"is not the identity"});
  expect_parts(error(imu, "1e-4", "-1e-4"), {"'gyroscope_noise_density': is -0.0001"});
  fs::remove(folder / imu);
  expect_parts(input_error([&] { read_recording(folder); }), {"imu0_sensor.yaml: no such file"});
}

TEST_F(AprilFolder, ATruthOfAnotherFrameIsNoticedByItsGravity) {
  std::string text = test::slurp(folder / "imu0.csv"), changed = "#ts,wx,wy,wz,ax,ay,az\n";
  for (const ImuSample& s : truth.imu) {
    changed += fmt::format("{},{},{}\n", s.time.count(), csv(s.angular_rate_imu),
                           csv(Eigen::Vector3d(0.5 * s.specific_force_imu)));
  }
  test::spill(folder / "imu0.csv", changed);
  expect_parts(input_error([&] { read_recording(folder); }),
               {"gt_pnp.csv: with the IMU's samples gravity is 5.", "expected 9.807"});
  test::spill(folder / "imu0.csv", text.substr(0, text.find("\n2000000000,") + 1));
  expect_parts(input_error([&] { read_recording(folder); }), {"too few poses"});
}

// The real recordings.

std::optional<fs::path> euroc() {
  const auto folder = test::recordings();
  if (!folder || !fs::exists(folder->parent_path() / "euroc")) return std::nullopt;
  return folder->parent_path() / "euroc";
}

TEST(RealApril, IsReadWithEveryTrapHandled) {
  const auto folder = euroc();
  if (!folder) GTEST_SKIP() << "skipped: no recordings";
  const Recording r = read_recording(*folder / "imu_april");
  EXPECT_EQ(r.name, "imu_april");
  EXPECT_EQ(r.imu.size(), 14374u);
  EXPECT_EQ(r.frames.size(), 1417u);
  EXPECT_EQ(r.true_landmarks.size(), 144u);
  EXPECT_EQ(r.truth.size(), 1336u);
  std::size_t pixels = 0;
  for (const FeatureFrame& frame : r.frames) pixels += frame.pixels.size();
  EXPECT_EQ(pixels, 358288u);
  expect_parts(joined_remarks(r.remarks), {"no frame for 1.15 s, from 55.80 s on",
                                           "2 of 1417 frames", "81 of 1417 poses", "z points up"});
  // The right camera is 11 cm beside the left one.
  EXPECT_NEAR((r.cameras[1].cam_T_imu * r.cameras[0].cam_T_imu.inverse()).p.norm(), 0.110, 1e-3);
}

TEST(RealApril, TheCornersLieWhereTheTruthSeesThem) {
  const auto folder = euroc();
  if (!folder) GTEST_SKIP() << "skipped: no recordings";
  const Recording r = read_recording(*folder / "imu_april");
  std::vector<double> errors;
  std::size_t k = 0;
  for (const FeatureFrame& frame : r.frames) {
    while (k < r.truth.size() && r.truth[k].time < frame.time) ++k;
    if (k == r.truth.size() || r.truth[k].time != frame.time) continue;
    for (const PixelObservation& o : frame.pixels) {
      const Camera& camera = r.cameras[static_cast<std::size_t>(o.camera)];
      const auto& corner = r.true_landmarks[static_cast<std::size_t>(o.landmark)];
      ASSERT_EQ(corner.id, o.landmark);
      const auto seen =
          project(camera, camera.cam_T_imu * (r.truth[k].pose.inverse() * corner.p_world));
      errors.push_back(seen ? (seen->pixel - o.pixel).norm() : 1e9);
    }
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_GT(errors.size(), 340000u);
  EXPECT_LT(errors[errors.size() / 2], 0.4);
  EXPECT_LT(errors[errors.size() * 99 / 100], 1.5);
}

/// The end of dead reckoning over two seconds from the true state, against the truth [m]: the
/// median, a start every second.
double dead_reckoning_error(const Recording& r, const std::vector<TrueMotion>& motion) {
  std::vector<double> errors;
  ImuBuffer buffer({.convention = r.imu_convention});
  for (const ImuSample& sample : r.imu) buffer.add(sample);
  std::size_t end = 0;
  Time next = Time::min();
  for (std::size_t k = 0; k < r.truth.size(); ++k) {
    if (r.truth[k].time < next) continue;
    next = r.truth[k].time + from_seconds(1);
    while (end < r.truth.size() && r.truth[end].time < r.truth[k].time + from_seconds(2)) ++end;
    if (end == r.truth.size()) break;
    InertialState state{.world_T_imu = r.truth[k].pose,
                        .v_world = motion[k].v_world,
                        .accelerometer_bias = motion[k].accelerometer_bias,
                        .gyroscope_bias = motion[k].gyroscope_bias};
    for (const ImuInterval& interval : buffer.between(r.truth[k].time, r.truth[end].time)) {
      state = integrate(state, interval, {0, 0, -9.81});
    }
    errors.push_back((state.world_T_imu.p - r.truth[end].pose.p).norm());
  }
  std::sort(errors.begin(), errors.end());
  return errors[errors.size() / 2];
}

struct Sequence {
  const char* name;
  std::size_t samples, poses;
  double error;  // of dead reckoning over 2 s [m]; 0: the truth holds poses only
  const char* remark;
};

class RealImu : public ::testing::TestWithParam<Sequence> {};

TEST_P(RealImu, TheTrueStatesMoveAsTheImuSays) {
  const auto folder = euroc();
  if (!folder) GTEST_SKIP() << "skipped: no recordings";
  const Sequence& expected = GetParam();
  const Recording r =
      read_recording(*folder / "imu_gt" / (std::string(expected.name) + "_imu.csv.gz"));
  EXPECT_EQ(r.name, expected.name);
  EXPECT_EQ(r.imu.size(), expected.samples);
  EXPECT_EQ(r.truth.size(), expected.poses);
  EXPECT_TRUE(r.frames.empty());
  ASSERT_EQ(r.true_motion.size(), expected.error > 0 ? expected.poses : 0u);
  for (std::size_t k = 0; k < r.true_motion.size(); ++k) {
    ASSERT_EQ(r.true_motion[k].time, r.truth[k].time);
  }
  expect_parts(joined_remarks(r.remarks), {expected.remark});
  if (expected.error == 0) return;
  const double error = dead_reckoning_error(r, r.true_motion);
  EXPECT_LT(error, expected.error);
  // The result of the columns in another order.
  std::vector<TrueMotion> swapped = r.true_motion;
  for (TrueMotion& row : swapped) std::swap(row.accelerometer_bias, row.gyroscope_bias);
  EXPECT_GT(dead_reckoning_error(r, swapped), 3 * error);
}

INSTANTIATE_TEST_SUITE_P(
    Euroc, RealImu,
    ::testing::Values(Sequence{"MH_01_easy", 36820, 36382, 0.06, "begins 1.08 s after"},
                      Sequence{"MH_03_medium", 27008, 26302, 0, "poses only"},
                      // The worlds of the Vicon rooms are not level.
                      Sequence{"V1_01_easy", 29120, 2895, 0.1, "leans 0.2 deg"},
                      Sequence{"V1_02_medium", 17100, 16702, 0.1, "leans 0.1 deg"},
                      Sequence{"V2_01_easy", 22800, 22401, 0.2, "leans 0.5 deg"}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST(EurocImu, ANameInOtherBytesThanUtf8IsReadAsUtf8) {
  const auto file = test::scratch() / "caf\xe9_imu.csv";
  test::spill(file, "#ts,wx,wy,wz,ax,ay,az\n1,2,3,4,5,6,7\n");
  const Recording r = read_recording(file);
  EXPECT_EQ(r.name, "caf\xef\xbf\xbd");
  expect_parts(joined_remarks(r.remarks), {"there is no caf\xef\xbf\xbd_gt.csv"});
}

// As those of TUM-VI.
TEST(EurocImu, ATruthOfPosesAloneIsRead) {
  const auto folder = test::scratch();
  test::spill(folder / "walk_imu.csv",
              "#ts,wx,wy,wz,ax,ay,az\n1000000,2,3,4,5,6,7\n"
              "9000000,2,3,4,5,6,7\n");
  test::spill(folder / "walk_gt.csv",
              "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], "
              "q_RS_y [], q_RS_z []\n2000000,1,2,3,0,0,0,1\n8000000,1,2,4,0,0,0,1\n");
  const Recording r = read_recording(folder / "walk_imu.csv");
  ASSERT_EQ(r.truth.size(), 2u);
  EXPECT_EQ(r.truth[1].pose.p, Eigen::Vector3d(1, 2, 4));
  EXPECT_NEAR(r.truth[1].pose.R(0, 0), -1, 1e-15) << "the real part comes first";
  EXPECT_TRUE(r.truth_attitudes);
  EXPECT_TRUE(r.true_motion.empty());
  expect_parts(joined_remarks(r.remarks), {"walk_gt.csv holds poses only"});
}

TEST(EurocImu, ReadsPlainTablesAndWithoutTruth) {
  const auto file = test::scratch() / "walk_imu.csv";
  test::spill(file, "#ts,wx,wy,wz,ax,ay,az\n1,2,3,4,5,6,7\n");
  const Recording r = read_recording(file);
  EXPECT_EQ(r.name, "walk");
  EXPECT_EQ(r.imu[0].angular_rate_imu, Eigen::Vector3d(2, 3, 4));
  EXPECT_EQ(r.imu[0].specific_force_imu, Eigen::Vector3d(5, 6, 7));
  expect_parts(joined_remarks(r.remarks), {"no truth: there is no walk_gt.csv"});
  test::spill(file, "#ts,wx,wy,wz,ax,ay,az\n");
  expect_parts(input_error([&] { read_recording(file); }), {"walk_imu.csv: holds no sample"});
}

TEST(RealRecordings, InertialOnesSurviveTheProjectsOwnFolder) {
  const auto folder = euroc();
  if (!folder) GTEST_SKIP() << "skipped: no recordings";
  for (const char* path : {"imu_april", "imu_gt/V1_01_easy_imu.csv.gz"}) {
    const Recording r = read_recording(*folder / path);
    const auto own = test::scratch();
    write_folder_recording(r, own);
    const Recording again = read_recording(own);
    EXPECT_EQ(again.remarks, r.remarks);
    ASSERT_EQ(again.imu.size(), r.imu.size());
    EXPECT_EQ(again.imu.back().specific_force_imu, r.imu.back().specific_force_imu);
    EXPECT_EQ(again.truth.size(), r.truth.size());
    EXPECT_EQ(again.true_motion.size(), r.true_motion.size());
    ASSERT_EQ(again.frames.size(), r.frames.size());
    for (std::size_t k = 0; k < r.frames.size(); ++k) {
      ASSERT_EQ(again.frames[k].pixels.size(), r.frames[k].pixels.size());
      for (std::size_t i = 0; i < r.frames[k].pixels.size(); ++i) {
        ASSERT_EQ(again.frames[k].pixels[i].pixel, r.frames[k].pixels[i].pixel);
      }
    }
  }
}

}  // namespace
}  // namespace chasles
