#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

class KltTracks : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = test::scratch();
    file = folder / "hall_klt_tracks_cam0.csv";
    test::spill(folder / "hall_imu.csv", test::kEurocImuColumns + test::five_samples());
    write("5000000,0,379,48\n5000000,1,713,295\n10000000,0,380.5,47\n");
  }
  void write(const std::string& rows) const {
    test::spill(file, "#timestamp [ns],track_id,u [px],v [px]  (raw distorted pixels)\n" + rows);
  }
  std::string error() const {
    return input_error([&] { read_recording(file); });
  }
  fs::path folder, file;
};

TEST_F(KltTracks, AreReadWithTheSamplesBeside) {
  const Recording r = read_recording(file);
  EXPECT_EQ(r.name, "hall_tracks");
  EXPECT_EQ(r.imu.size(), 5u);
  ASSERT_EQ(r.frames.size(), 2u);
  ASSERT_EQ(r.frames[0].pixels.size(), 2u);
  EXPECT_EQ(r.frames[1].pixels[0].landmark, 0);
  EXPECT_EQ(r.frames[1].pixels[0].pixel, Eigen::Vector2d(380.5, 47));
  EXPECT_EQ(r.cameras[0].fx, 458.654) << "EuRoC's";
  test::spill(folder / "cam0_sensor.yaml", test::kEurocCamera0);
  expect_parts(error(), {"(379, 48) lies outside the image of 8 x 6 px"});
}

TEST_F(KltTracks, MalformedTablesAreRejected) {
  write("5000000,0,379,48\n4000000,1,713,295\n");
  expect_parts(error(), {"cam0.csv:3", "expected times that rise strictly"});
  write("5000000,0,379,48\n5000000,0,379,48\n");
  expect_parts(error(), {"cam0.csv:3", "track 0 is there twice"});
  write("5000000,0,379,nan\n");
  expect_parts(error(), {"cam0.csv:2", "nan"});
  write("5000000,0,379,4.");
  expect_parts(error(), {"truncated"});
  write("");
  expect_parts(error(), {"holds no track"});
  fs::remove(folder / "hall_imu.csv");
  expect_parts(error(), {"there is no hall_imu.csv"});
  fs::rename(file, folder / "tracks_of_hall.csv");
  expect_parts(input_error([&] { read_recording(folder / "tracks_of_hall.csv"); }),
               {"expected a name SEQUENCE_klt_tracks_cam0.csv"});
}

// The expected counts are from awk.
TEST(RealKltTracks, AreReadWhole) {
  const auto kitti = test::recordings();
  if (!kitti) GTEST_SKIP() << "skipped: no recordings";
  const Recording r =
      read_recording(kitti->parent_path() / "euroc/imu_gt/MH_01_easy_klt_tracks_cam0.csv.gz");
  EXPECT_EQ(r.name, "MH_01_easy_tracks");
  EXPECT_EQ(r.frames.size(), 3682u);
  EXPECT_EQ(r.frames.front().pixels.front().pixel, Eigen::Vector2d(379, 48));
  EXPECT_GT(r.imu.size(), 36000u);
  EXPECT_FALSE(r.truth.empty());
  EXPECT_FALSE(r.true_motion.empty());
  EXPECT_EQ(r.imu_noise->gyroscope_noise_density, 1.6968e-4);
}

}  // namespace
}  // namespace chasles
