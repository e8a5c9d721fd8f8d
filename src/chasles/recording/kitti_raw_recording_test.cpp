#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

std::string lines_of(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

// A packet: position from `north` in thousandths of a degree, `yaw`, and the IMU's sample.
std::string packet(double north, double yaw, double force) {
  return fmt::format(
      "{} 8.4 110 0 0 {} 0 0 0 0 0 1 2 {} 3 4 5 0.1 0.2 0.3 6 7 8 0.05 0.01 4 11 6 6 6\n",
      49 + 1e-3 * north, yaw, force);
}

/// Three frames at 10 Hz with a pair of grey cameras, 0.54 m apart, and samples at 100 Hz in the
/// _extract folder. The axes of IMU and laser are the same, and the camera points forward.
class KittiRaw : public ::testing::Test {
 protected:
  void SetUp() override {
    day = test::scratch() / "2011_09_26";
    drive = day / "2011_09_26_drive_0001_sync";
    fs::create_directories(drive / "oxts/data");
    test::spill(day / "calib_imu_to_velo.txt",
                "calib_time: 25-May-2012 16:47:16\nR: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n");
    test::spill(day / "calib_velo_to_cam.txt",
                "calib_time: 15-Mar-2012\nR: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.1 -0.3\ndelta_f: 0 0\n");
    test::spill(day / "calib_cam_to_cam.txt",
                "corner_dist: 9.95e-02\nS_rect_00: 8 6\nR_rect_00: 1 0 0 0 1 0 0 0 1\n"
                "P_rect_00: 4 0 3.5 0 0 4 2.5 0 0 0 1 0\nS_rect_01: 8 6\n"
                "P_rect_01: 4 0 3.5 -2.16 0 4 2.5 0 0 0 1 0\n");
    for (int c = 0; c < 2; ++c) {
      const fs::path camera = drive / fmt::format("image_{:02}", c);
      fs::create_directories(camera / "data");
      for (int k = 0; k < 3; ++k) {
        test::spill(camera / "data" / fmt::format("{:010}.png", k),
                    test::picture_bytes(test::shade_of(c, k)));
      }
      // The second camera is stamped 40 us after the first.
      test::spill(camera / "timestamps.txt",
                  fmt::format("2011-09-26 13:02:25.9000{0}\n2011-09-26 13:02:26.0000{0}\n"
                              "2011-09-26 13:02:26.1000{0}\n",
                              4 * c));
    }
    test::spill(drive / "oxts/timestamps.txt",
                "2011-09-26 13:02:25.90\n2011-09-26 13:02:26.00\n2011-09-26 13:02:26.10\n");
    for (int k = 0; k < 3; ++k) {
      test::spill(drive / "oxts/data" / fmt::format("{:010}.txt", k), packet(k, 0.1 * k, 9.5));
    }
  }
  // Samples at 13:02:25.90 + these hundredths of a second.
  void write_extract(const std::vector<int>& hundredths) const {
    const fs::path oxts = day / "2011_09_26_drive_0001_extract/oxts";
    fs::create_directories(oxts / "data");
    std::string times;
    for (std::size_t k = 0; k < hundredths.size(); ++k) {
      const int h = 90 + hundredths[k];
      times += fmt::format("2011-09-26 13:02:{}.{:02}\n", 25 + h / 100, h % 100);
      test::spill(oxts / "data" / fmt::format("{:010}.txt", k), packet(0, 0, 9 + 0.1 * h));
    }
    test::spill(oxts / "timestamps.txt", times);
  }
  std::string error() const {
    return input_error([&] { read_recording(drive); });
  }
  fs::path day, drive;
};

TEST_F(KittiRaw, IsReadWithBothCamerasAndTheTruth) {
  const Recording r = read_recording(drive);
  EXPECT_EQ(r.name, "2011_09_26_drive_0001_sync");
  ASSERT_EQ(r.cameras.size(), 2u);
  // From the IMU 1.11 m forward, that is along the camera's z axis; y left is -x, z up is -y.
  const Eigen::Vector3d cam0 = r.cameras[0].cam_T_imu * Eigen::Vector3d(3, 1, 2);
  EXPECT_LT((cam0 - Eigen::Vector3d(-1.3, -1.3, 1.9)).norm(), 1e-12);
  const SE3 cam1_T_cam0 = r.cameras[1].cam_T_imu * r.cameras[0].cam_T_imu.inverse();
  EXPECT_LT((cam1_T_cam0.p - Eigen::Vector3d(-0.54, 0, 0)).norm(), 1e-12);
  ASSERT_EQ(r.images->size(), 3u);
  EXPECT_EQ(r.images->time(0).count(), 1317042145900000000);
  EXPECT_EQ(r.images->read(2).images[1].pixels[0], test::shade_of(1, 2));
  ASSERT_EQ(r.truth.size(), 3u);
  // A thousandth of a degree to the north is 111.3 m at the equator's radius; the projection keeps
  // its scale at the first latitude.
  EXPECT_NEAR(r.truth[1].pose.p.y(), 6378137 * 1e-3 * M_PI / 180, 0.01);
  EXPECT_NEAR(r.truth[1].pose.p.x(), 0, 1e-9);
  ASSERT_TRUE(r.georeference);
  const Geodetic place = to_geodetic(*r.georeference, r.truth[1].pose.p);
  EXPECT_NEAR(place.latitude, 49.001, 1e-12);
  EXPECT_NEAR(place.longitude, 8.4, 1e-12);
  EXPECT_NEAR(place.altitude, 110, 1e-9);
  EXPECT_NEAR(so3::log(r.truth[2].pose.R).z(), 0.2, 1e-12);
  ASSERT_EQ(r.imu.size(), 3u);
  EXPECT_EQ(r.imu[0].specific_force_imu, Eigen::Vector3d(1, 2, 9.5));
  EXPECT_EQ(r.imu[0].angular_rate_imu, Eigen::Vector3d(0.1, 0.2, 0.3));
  expect_parts(lines_of(r.remarks), {"10 Hz", "_extract"});
}

TEST_F(KittiRaw, TheFastSamplesAreTakenFromBesideAndPutInOrder) {
  write_extract({0, 1, 2, 5, 3, 4, 4, 20});
  const Recording r = read_recording(drive);
  ASSERT_EQ(r.imu.size(), 7u);
  for (std::size_t k = 1; k < r.imu.size(); ++k) EXPECT_GT(r.imu[k].time, r.imu[k - 1].time);
  EXPECT_EQ(to_seconds(r.imu[4].time - r.imu[0].time), 0.04);
  expect_parts(lines_of(r.remarks),
               {"3 of 8 IMU samples came after later ones", "1 of 8 IMU samples repeat the time"});
  const fs::path extract = day / "2011_09_26_drive_0001_extract";
  fs::create_directories(extract / "image_00");
  expect_parts(input_error([&] { read_recording(extract); }),
               {"not rectified", "give 2011_09_26_drive_0001_sync"});
}

// The line of a frame that was lost is empty, and its files are not there.
TEST_F(KittiRaw, ALostFrameMovesNoOther) {
  for (const char* sensor : {"image_00", "image_01", "oxts"}) {
    std::string text = test::slurp(drive / sensor / "timestamps.txt");
    const std::size_t first = text.find('\n') + 1, second = text.find('\n', first);
    test::spill(drive / sensor / "timestamps.txt", text.erase(first, second - first) + "\n");
    const char* ending = std::string(sensor) == "oxts" ? ".txt" : ".png";
    fs::remove(drive / sensor / "data" / ("0000000001" + std::string(ending)));
  }
  const Recording r = read_recording(drive);
  ASSERT_EQ(r.images->size(), 2u);
  EXPECT_EQ(r.images->time(1).count(), 1317042146100000000);
  EXPECT_EQ(r.images->read(1).images[0].pixels[0], test::shade_of(0, 2));
  EXPECT_EQ(r.imu.size(), 2u);
  ASSERT_EQ(r.truth.size(), 2u);
  EXPECT_NEAR(so3::log(r.truth[1].pose.R).z(), 0.2, 1e-12);
  EXPECT_EQ(read_recording(drive, {.cameras = 1}).cameras.size(), 1u);
}

TEST_F(KittiRaw, MalformedFilesAreNamed) {
  test::spill(drive / "oxts/data/0000000001.txt", "49.0 8.4 110\n");
  expect_parts(error(), {"0000000001.txt", "holds 3 numbers, expected 30"});
  test::spill(drive / "oxts/data/0000000001.txt", packet(0, 0, std::nan("")));
  expect_parts(error(), {"0000000001.txt", "number 14", "nan"});
  fs::remove(drive / "oxts/data/0000000001.txt");
  expect_parts(error(), {"0000000001.txt", "no such file"});
  test::spill(drive / "oxts/data/0000000001.txt", packet(0, 0, 9));
  for (const char* time : {"2011-13-26 13:02:26.00", "2011-09-26 25:02:26.00", "13:02:26.00",
                           "2011-09-26 13:02:xx.00", "9999-09-26 13:02:26.00"}) {
    test::spill(drive / "oxts/timestamps.txt", std::string("2011-09-26 13:02:25.90\n") + time);
    expect_parts(error(), {"oxts/timestamps.txt:2"});
  }
  test::spill(drive / "oxts/timestamps.txt", "\n");
  expect_parts(error(), {"oxts/timestamps.txt", "holds no time"});
}

TEST_F(KittiRaw, AMissingOrWrongCalibrationIsNamed) {
  test::spill(day / "calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0\nT: 0 0 0\n");
  expect_parts(error(), {"calib_imu_to_velo.txt", "'R'", "holds 8 numbers, expected 9"});
  test::spill(day / "calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 -1\nT: 0 0 0\n");
  expect_parts(error(), {"calib_imu_to_velo.txt", "reflection"});
  test::spill(day / "calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 1\n");
  expect_parts(error(), {"calib_imu_to_velo.txt", "'T': is missing"});
  fs::remove(day / "calib_imu_to_velo.txt");
  expect_parts(error(), {"calib_imu_to_velo.txt", "no such file"});
}

TEST_F(KittiRaw, ASizeThatIsNoneIsNamed) {
  const std::string text = test::slurp(day / "calib_cam_to_cam.txt");
  for (const char* size : {"1e300 6", "0.5 6", "8 -6"}) {
    std::string changed = text;
    test::spill(day / "calib_cam_to_cam.txt", changed.replace(text.find("8 6"), 3, size));
    expect_parts(error(), {"calib_cam_to_cam.txt", "'S_rect_00'", "whole number of pixels"});
  }
}

}  // namespace
}  // namespace chasles
