#include <chasles/recording/image_files.hpp>
#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

class EurocFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    rec = test::scratch() / "hall";
    test::write_euroc_folder(rec, 2);
    mav = rec / "mav0";
  }
  /// Replaces the first occurrence in a file.
  void change(const fs::path& file, const std::string& from, const std::string& to) const {
    std::string text = test::slurp(mav / file);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    test::spill(mav / file, text.replace(at, from.size(), to));
  }
  std::string error() const {
    return input_error([&] { read_recording(rec); });
  }
  fs::path rec, mav;
};

TEST_F(EurocFolder, IsReadWholeFromEitherFolder) {
  for (const fs::path& path : {rec, mav, mav / ""}) {
    const Recording r = read_recording(path);
    EXPECT_EQ(r.name, "hall");
    ASSERT_EQ(r.cameras.size(), 2u);
    // T_BS maps camera to body: the camera is at (0.1, 0.2, 0.3).
    EXPECT_LT((r.cameras[1].cam_T_imu * Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-15);
    EXPECT_EQ(r.cameras[0].fy, 4.5);
    EXPECT_EQ(r.imu_noise->accelerometer_random_walk, 3e-3);
    ASSERT_EQ(r.imu.size(), 5u);
    EXPECT_EQ(r.imu[3].angular_rate_imu, Eigen::Vector3d(0.1, 0.2, 3));
    EXPECT_EQ(r.imu[3].specific_force_imu, Eigen::Vector3d(1, 2, 9.5));
    ASSERT_EQ(r.truth.size(), 2u);
    EXPECT_EQ(r.truth[1].pose.p.z(), 4);
    EXPECT_EQ(r.true_motion[0].gyroscope_bias.x(), 7);
    EXPECT_EQ(joined(r.remarks), "");
  }
}

TEST_F(EurocFolder, ImagesAreThoseOfTheFilesToTheLastPixel) {
  const Recording r = read_recording(rec);
  ASSERT_EQ(r.images->size(), 3u);
  for (int k = 0; k < test::kFrames; ++k) {
    const ImageFrame frame = r.images->read(static_cast<std::size_t>(k));
    EXPECT_EQ(frame.time, std::chrono::milliseconds(5 * (k + 1)));
    ASSERT_EQ(frame.images.size(), 2u);
    for (int c = 0; c < 2; ++c) {
      const auto camera = static_cast<std::size_t>(c);
      const GrayImage& image = frame.images[camera];
      const fs::path file = image_file(*r.images, static_cast<std::size_t>(k), camera);
      EXPECT_EQ(file.parent_path(), mav / ("cam" + std::to_string(c)) / "data");
      EXPECT_TRUE(fs::is_regular_file(file)) << file;
      ASSERT_EQ(image.width, 8);
      ASSERT_EQ(image.height, 6);
      ASSERT_EQ(image.pixels.size(), 48u);
      for (int i = 0; i < 48; ++i) {
        EXPECT_EQ(image.pixels[static_cast<std::size_t>(i)], test::shade_of(c, k) + i % 8);
      }
    }
  }
}

TEST_F(EurocFolder, OneCameraWithoutTruthIsARecordingToo) {
  fs::remove_all(mav / "cam1");
  fs::remove_all(mav / "state_groundtruth_estimate0");
  const Recording r = read_recording(rec);
  EXPECT_EQ(r.cameras.size(), 1u);
  EXPECT_EQ(r.images->read(0).images.size(), 1u);
  EXPECT_TRUE(r.truth.empty());
  expect_parts(joined(r.remarks), {"no truth"});
}

TEST_F(EurocFolder, AnEquidistantCameraIsReadAsOne) {
  change("cam0/sensor.yaml", "radial-tangential", "equidistant");
  EXPECT_EQ(read_recording(rec).cameras[0].distortion, Distortion::kEquidistant);
}

TEST_F(EurocFolder, AMissingImageLeavesTheOtherCamerasOne) {
  fs::remove(mav / "cam1/data/10000000.png");
  const Recording r = read_recording(rec);
  ASSERT_EQ(r.images->size(), 3u);
  EXPECT_FALSE(r.images->read(1).images[0].empty());
  EXPECT_TRUE(r.images->read(1).images[1].empty());
  expect_parts(joined(r.remarks), {"1 of 3 images of cam1 are listed, but are not in its folder",
                                   "cam1 has an image for 2 of the 3 frames of cam0"});
}

TEST_F(EurocFolder, CamerasAreThoseOfOneInstantWithinTwoMilliseconds) {
  change("cam1/data.csv", "10000000,", "11900000,");
  change("cam1/data.csv", "15000000,", "17100000,");
  const Recording r = read_recording(rec);
  ASSERT_EQ(r.images->size(), 3u) << "those of the first camera";
  EXPECT_EQ(r.images->time(1), std::chrono::milliseconds(10));
  EXPECT_FALSE(r.images->read(1).images[1].empty());
  EXPECT_TRUE(r.images->read(2).images[1].empty());
  EXPECT_FALSE(image_file(*r.images, 1, 1).empty());
  EXPECT_EQ(image_file(*r.images, 2, 1), "");
  expect_parts(joined(r.remarks), {"cam1 has an image for 2 of the 3 frames of cam0; 1 of its "
                                   "images are more than 2 ms from all of them: left out"});
}

TEST_F(EurocFolder, AllCamerasAreReadAndOneThatLooksElsewhereHasFramesOfItsOwn) {
  test::write_euroc_folder(rec, 4);
  EXPECT_EQ(read_recording(rec).cameras.size(), 4u);
  change("cam2/sensor.yaml", "0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1",
         "0, 1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, -1");
  change("cam2/data.csv", "10000000,", "12500000,");
  const Recording r = read_recording(rec);
  ASSERT_EQ(r.images->size(), 4u);
  EXPECT_EQ(r.images->time(2), std::chrono::microseconds(12500));
  const ImageFrame own = r.images->read(2);
  ASSERT_EQ(own.images.size(), 4u);
  for (std::size_t c = 0; c < 4; ++c) EXPECT_EQ(own.images[c].empty(), c != 2);
  EXPECT_TRUE(r.images->read(1).images[2].empty());
  expect_parts(joined(r.remarks), {"1 of the 3 images of cam2 are at other instants", "2.5 ms",
                                   "frames of their own"});
}

TEST_F(EurocFolder, CamerasThatAreNotTriggeredTogetherAreTheFirstAlone) {
  change("cam1/data.csv", "5000000,", "7500000,");
  change("cam1/data.csv", "10000000,", "12500000,");
  change("cam1/data.csv", "15000000,", "17500000,");
  const Recording r = read_recording(rec);
  ASSERT_EQ(r.images->size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_FALSE(r.images->read(i).images[0].empty());
    EXPECT_TRUE(r.images->read(i).images[1].empty());
  }
  expect_parts(joined(r.remarks), {"cam1 is not used: none of its 3 images is within 2 ms of one "
                                   "of cam0, the nearest is 2.5 ms off"});
}

TEST_F(EurocFolder, DisorderAndRepetitionArePutRightAndCounted) {
  test::spill(mav / "imu0/data.csv", std::string(test::kEurocImuColumns) +
                                         "0,0,0,0,0,0,1\n10000000,0,0,0,0,0,2\n"
                                         "5000000,0,0,0,0,0,3\n10000000,0,0,0,0,0,4\n"
                                         "20000000,0,0,0,0,0,5\n");
  test::spill(mav / "cam0/data.csv",
              "#timestamp [ns],filename\n10000000,10000000.png\n5000000,5000000.png\n"
              "5000000,15000000.png\n15000000,15000000.png\n");
  const Recording r = read_recording(rec);
  std::vector<double> forces;
  for (const ImuSample& s : r.imu) forces.push_back(s.specific_force_imu.z());
  EXPECT_EQ(forces, (std::vector<double>{1, 3, 2, 5})) << "the first of a time stays";
  ASSERT_EQ(r.images->size(), 3u);
  EXPECT_EQ(r.images->read(0).images[0].pixels[0], test::shade_of(0, 0));
  expect_parts(
      joined(r.remarks),
      {"1 of 5 IMU samples came after later ones", "1 of 5 IMU samples repeat the time",
       "2 of 4 images of cam0 came after later ones", "1 of 4 images of cam0 repeat the time"});
}

TEST_F(EurocFolder, WithoutATableTheNamesAreTheTimes) {
  fs::remove(mav / "cam0/data.csv");
  EXPECT_EQ(read_recording(rec).images->time(2), std::chrono::milliseconds(15));
}

TEST_F(EurocFolder, ASensorFileMayStateATimeOffset) {
  for (const char* file : {"cam0/sensor.yaml", "cam1/sensor.yaml"}) {
    test::spill(mav / file, test::slurp(mav / file) + "timeshift_cam_imu: -0.001\n");
  }
  const Recording r = read_recording(rec);
  EXPECT_EQ(r.images->time(0), std::chrono::milliseconds(4));
  expect_parts(joined(r.remarks), {"cam1 are 1.000 ms late"});
}

// A byte-order mark, no last line end, and OpenCV's kind of matrix.
TEST_F(EurocFolder, FilesOfOtherProgramsAreRead) {
  for (const char* file :
       {"cam0/data.csv", "imu0/data.csv", "state_groundtruth_estimate0/data.csv"}) {
    std::string text = test::slurp(mav / file);
    while (text.back() == '\n' || text.back() == '\r') text.pop_back();
    test::spill(mav / file, "\xef\xbb\xbf" + text);
  }
  change("cam0/sensor.yaml", "T_BS:\n", "T_BS: !!opencv-matrix\n  dt: d\n");
  const Recording r = read_recording(rec);
  EXPECT_EQ(r.imu.size(), 5u);
  EXPECT_EQ(r.images->size(), 3u);
  EXPECT_EQ(r.truth.size(), 2u);
  for (const std::string& remark : r.remarks) expect_parts(remark, {"data.csv has no line end"});
  EXPECT_EQ(r.remarks.size(), 3u);
}

TEST_F(EurocFolder, ASecondCameraWithoutImagesIsLeftOut) {
  fs::remove_all(mav / "cam1/data");
  fs::remove(mav / "cam1/data.csv");
  Recording r = read_recording(rec);
  EXPECT_EQ(r.cameras.size(), 1u);
  expect_parts(joined(r.remarks), {"cam1 is calibrated, but has no images: left out"});
  fs::remove(mav / "cam1/sensor.yaml");
  r = read_recording(rec, {.cameras = 1});
  EXPECT_EQ(r.images->read(0).images.size(), 1u);
  EXPECT_EQ(joined(r.remarks), "");
}

// TUM-VI: Kalibr's files in dso/, poses in mocap0, no sensor.yaml.
TEST_F(EurocFolder, KalibrsFilesServeWithoutSensorFiles) {
  for (const char* sensor : {"cam0", "cam1", "imu0"}) fs::remove(mav / sensor / "sensor.yaml");
  fs::remove_all(mav / "state_groundtruth_estimate0");
  fs::create_directories(mav / "mocap0");
  test::spill(mav / "mocap0/data.csv",
              "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], "
              "q_RS_y [], q_RS_z []\n5000000,1,2,3,0,0,0,1\n10000000,1,2,4,0,0,0,1\n");
  expect_parts(error(), {"cam0/sensor.yaml", "no camchain-imucam.yaml"});
  const auto camera = [](int c) {
    return fmt::format(
        "cam{}:\n  T_cam_imu: [[1, 0, 0, {}], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
        "  camera_model: pinhole\n  distortion_model: equidistant\n"
        "  distortion_coeffs: [0, 0, 0, 0]\n  intrinsics: [4, 4, 3.5, 2.5]\n"
        "  resolution: [8, 6]\n",
        c, 0.5 + c);
  };
  fs::create_directories(rec / "dso");
  test::spill(rec / "dso/camchain.yaml", camera(0) + camera(1));
  test::spill(rec / "dso/imu_config.yaml",
              "accelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\n"
              "gyroscope_noise_density: 0.005\ngyroscope_random_walk: 4.0e-06\n");
  const Recording r = read_recording(rec);
  ASSERT_EQ(r.cameras.size(), 2u);
  EXPECT_EQ(r.cameras[1].cam_T_imu.p.x(), 1.5);
  EXPECT_EQ(r.imu_noise->gyroscope_noise_density, 0.005);
  ASSERT_EQ(r.truth.size(), 2u);
  EXPECT_EQ(r.truth[1].pose.p.z(), 4);
  EXPECT_NEAR(r.truth[0].pose.R(0, 0), -1, 1e-15) << "the real part comes first";
  test::spill(mav / "mocap0/sensor.yaml",
              "sensor_type: pose\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, 0, 0, 1, 0, 0, "
              "0, 0, 1, 0.5, 0, 0, 0, 1]\n");
  EXPECT_EQ(read_recording(rec).truth[1].pose.p.z(), 3.5) << "of the body below the marker";
  EXPECT_EQ(r.images->read(2).images[1].pixels[0], test::shade_of(1, 2));
  test::spill(mav / "cam0/sensor.yaml", test::kEurocCamera0);
  test::spill(mav / "cam1/sensor.yaml", test::kEurocCamera0);
  test::spill(mav / "imu0/sensor.yaml", test::kEurocImu0);
  expect_parts(joined(read_recording(rec).remarks),
               {"sensor.yaml files, and camchain.yaml is not"});
}

TEST_F(EurocFolder, PositionsOfATotalStationAreATruthWithoutAttitudes) {
  fs::remove_all(mav / "state_groundtruth_estimate0");
  expect_parts(joined(read_recording(rec).remarks), {"no truth: there is neither"});
  fs::create_directories(mav / "leica0");
  test::spill(mav / "leica0/data.csv",
              "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m]\n5000000,1,2,3\n"
              "10000000,1,2,4\n");
  test::spill(mav / "leica0/sensor.yaml",
              "sensor_type: position\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, 0.1, 0, 1, 0, "
              "-0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]\n");
  const Recording r = read_recording(rec);
  ASSERT_EQ(r.truth.size(), 2u);
  EXPECT_EQ(r.truth[1].pose.p, Eigen::Vector3d(1, 2, 4));
  EXPECT_FALSE(r.truth_attitudes);
  EXPECT_EQ(r.truth_point_imu, Eigen::Vector3d(0.1, -0.2, 0.3));
  expect_parts(joined(r.remarks), {"the truth is leica0/data.csv"});
}

TEST_F(EurocFolder, FramesOutsideTheSamplesAreCounted) {
  change("cam0/data.csv", "15000000,", "25000000,");
  change("cam1/data.csv", "15000000,", "25000000,");
  expect_parts(joined(read_recording(rec).remarks), {"1 of 3 frames are before the first IMU"});
}

TEST_F(EurocFolder, MissingFilesAreNamed) {
  for (const char* file :
       {"cam0/sensor.yaml", "cam1/sensor.yaml", "imu0/sensor.yaml", "imu0/data.csv"}) {
    const std::string bytes = test::slurp(mav / file);
    fs::remove(mav / file);
    expect_parts(error(), {file, "no such file"});
    test::spill(mav / file, bytes);
  }
  fs::remove_all(mav / "cam0/data");
  expect_parts(error(), {"cam0/data", "no such folder"});
  fs::create_directories(mav / "cam0/data");
  expect_parts(error(), {"cam0/data", "none of the 3 images of cam0 is there"});
  fs::remove_all(mav / "cam0");
  expect_parts(error(), {"cam0/sensor.yaml"});
  fs::remove_all(mav);
  expect_parts(error(), {"hall", "is empty"});
}

TEST_F(EurocFolder, MalformedTablesAreRejectedWithTheirLine) {
  change("imu0/data.csv", "0,0.1,0.2,0,", "0,0.1,none,0,");
  expect_parts(error(), {"imu0/data.csv:2", "w_RS_S_y", "none"});
  test::spill(mav / "imu0/data.csv", std::string(test::kEurocImuColumns) + "0,0.1,0.2,0,1,2,9.");
  expect_parts(error(), {"imu0/data.csv", "truncated"});
  test::spill(mav / "imu0/data.csv", std::string(test::kEurocImuColumns));
  expect_parts(error(), {"imu0/data.csv", "holds no sample"});
  test::spill(mav / "imu0/data.csv", "#timestamp [ns],a_RS_S_x [m s^-2]\n1,2\n");
  expect_parts(error(), {"imu0/data.csv:1", "columns"});
  change("cam0/data.csv", "10000000,", "ten,");
  expect_parts(error(), {"cam0/data.csv:3", "ten"});
  test::spill(mav / "cam0/data.csv", "#timestamp [ns],filename\n");
  expect_parts(error(), {"cam0/data.csv", "lists no image"});
}

TEST_F(EurocFolder, AnImpossibleCalibrationIsRejected) {
  const std::string good = test::slurp(mav / "cam0/sensor.yaml");
  const std::vector<std::array<std::string, 3>> cases{
      {"0.3, 0, 0, 0, 1]", "0.3, 0, 0, 0, 2]", "last row"},
      {"[0, -1, 0, 0.1", "[0, -0.9, 0, 0.1", "not a rotation"},
      {"[0, -1, 0, 0.1", "[0, 1, 0, 0.1", "reflection"},
      {"[0, -1, 0, 0.1", "[0, -1, 0, nan", "nan"},
      {"[8, 6]", "[8, 6.5]", "whole number of pixels"},
      {"[8, 6]", "[8]", "width, height"},
      {"[4, 4.5", "[-4, 4.5", "positive"},
      {"pinhole", "cubic", "'cubic' is a model that is not supported, expected a pinhole"},
      {"pinhole", "ds", "numbers: xi, alpha, fx, fy, cx, cy"},
      {"radial-tangential", "cubic", "'cubic' is a model that is not supported"},
      {"[-0.28, 0.07, 1e-4, 2e-5]", "[-0.28, 0.07]", "2 coefficients, expected 4"},
      {"sensor_type: camera", "sensor_type: lidar", "expected 'camera'"},
      {"T_BS:", "T_SB:", "T_BS"}};
  for (const auto& [from, to, part] : cases) {
    change("cam0/sensor.yaml", from, to);
    expect_parts(error(), {"cam0/sensor.yaml", part});
    test::spill(mav / "cam0/sensor.yaml", good);
  }
}

TEST_F(EurocFolder, DamagedImagesAreRejectedByName) {
  const fs::path file = mav / "cam1/data/10000000.png";
  const std::string good = test::slurp(file);
  const auto message = [&](const std::string& bytes) {
    test::spill(file, bytes);
    const Recording r = read_recording(rec);
    EXPECT_FALSE(r.images->read(0).images[1].empty()) << "the others are read";
    int damages = 0;
    const ImageFrame frame = r.images->read_undamaged(1, 2, [&](const InputError&) { ++damages; });
    EXPECT_EQ(damages, 1);
    EXPECT_FALSE(frame.images[0].empty());
    EXPECT_TRUE(frame.images[1].empty());
    return input_error([&] { r.images->read(1); });
  };
  std::string flipped = good;
  flipped[good.size() / 2] = static_cast<char>(flipped[good.size() / 2] ^ 4);
  expect_parts(message(flipped), {"cam1/data/10000000.png", "check sum"});
  expect_parts(message(good.substr(0, good.size() - 20)), {"10000000.png", "truncated"});
  expect_parts(message(good.substr(0, 20)), {"10000000.png", "truncated"});
  expect_parts(message(""), {"10000000.png", "is empty"});
  expect_parts(message("GIF89a"), {"10000000.png", "expected a PNG, JPEG, PGM, BMP, TIFF or WebP"});
  expect_parts(message(test::encoded(test::picture(3, 9, 6))),
               {"10000000.png", "is 9 x 6 pixels, expected 8 x 6"});
}

// The recording of issue 4. The expected counts are from wc and ls.
TEST(RealEurocFolder, IsReadWhole) {
  const auto kitti = test::recordings();
  if (!kitti) GTEST_SKIP() << "skipped: no recordings";
  const Recording r = read_recording(kitti->parent_path() / "euroc/MH_01_easy_17s");
  EXPECT_EQ(r.name, "MH_01_easy_17s");
  EXPECT_EQ(r.imu.size(), 3901u);
  EXPECT_EQ(r.truth.size(), 3901u);
  ASSERT_EQ(r.images->size(), 350u);
  EXPECT_EQ(r.images->time(0).count(), 1403636584763555584);
  // The two cameras of the sensor are 11 cm apart.
  const SE3 cam1_T_cam0 = r.cameras[1].cam_T_imu * r.cameras[0].cam_T_imu.inverse();
  EXPECT_NEAR(cam1_T_cam0.p.x(), -0.110, 1e-3);
  const ImageFrame frame = r.images->read(349);
  EXPECT_EQ(frame.images[1].width, 752);
  EXPECT_EQ(frame.images[1].pixels.size(), 752u * 480u);
  EXPECT_EQ(joined(r.remarks), "");
}

}  // namespace
}  // namespace chasles
