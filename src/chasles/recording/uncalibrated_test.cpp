#include <filesystem>
#include <fstream>
#include <unistd.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/image_encode.hpp>
#include <chasles/recording/calibration_to_write.hpp>
#include <chasles/recording/uncalibrated.hpp>

namespace chasles::test {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kStart = 1403636584763556000;

class Uncalibrated : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / fmt::format("chasles_uncalibrated_{}", ::getpid());
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const fs::path& name, const std::string& bytes) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }

  // Ten images of each camera at 20 Hz.
  void write_images(const std::string& before, int cameras, const std::string& after) const {
    for (int c = 0; c < cameras; ++c) {
      for (std::int64_t i = 0; i < 10; ++i) {
        const GrayImage image{
            .width = 8 + c, .height = 6, .pixels = std::vector<std::uint8_t>((8u + c) * 6, 100)};
        write(fmt::format("{}cam{}{}/{}.png", before, c, after, kStart + 50'000'000 * i),
              png_bytes(image));
      }
    }
  }

  static std::string imu_table() {
    std::string text = "timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n";
    for (std::int64_t i = -5; i < 110; ++i) {
      text += fmt::format("{},0.01,0.02,{},0.1,0.2,9.8\n", kStart + 5'000'000 * i, i % 7);
    }
    return text;
  }

  fs::path folder_;
};

constexpr const char* kNoise =
    "accelerometer_noise_density: 0.002\naccelerometer_random_walk: 0.003\n"
    "gyroscope_noise_density: 0.0002\ngyroscope_random_walk: 0.00002\n";

TEST_F(Uncalibrated, AFolderOfImagesNeedsNoCalibration) {
  write_images("", 2, "");
  write("imu.csv", imu_table());
  ASSERT_TRUE(is_uncalibrated(folder_));
  const Recording recording = read_uncalibrated(folder_);
  ASSERT_EQ(recording.cameras.size(), 2u);
  EXPECT_EQ(recording.cameras[1].width, 9);
  EXPECT_EQ(recording.cameras[0].fx, 0);
  ASSERT_EQ(recording.images->size(), 10u);
  EXPECT_EQ(recording.images->time(1), Time(kStart + 50'000'000));
  EXPECT_EQ(recording.images->read(3).images.size(), 2u);
  EXPECT_EQ(recording.imu.size(), 115u);
  EXPECT_FALSE(recording.imu_noise);
  write("imu.yaml", std::string(kNoise) + "rostopic: /imu0\nupdate_rate: 200.0\n");
  const Recording with_noise = read_uncalibrated(folder_);
  ASSERT_TRUE(with_noise.imu_noise);
  EXPECT_EQ(with_noise.imu_noise->gyroscope_noise_density, 0.0002);
  const CalibrationToWrite stated = find_calibration_to_replace(folder_).calibration;
  EXPECT_TRUE(stated.cameras.empty());
  EXPECT_EQ(stated.imu_noise->gyroscope_noise_density, 0.0002);
  EXPECT_NEAR(stated.imu_rate, 200, 1);
  EXPECT_THROW(find_calibration_to_write(folder_), InputError) << "it states no cameras";
  write("calibration.yaml", "format: chasles\n");
  EXPECT_FALSE(is_uncalibrated(folder_)) << "its reader says what is wrong";
}

TEST_F(Uncalibrated, EurocsFormNeedsNoSensorFiles) {
  write_images("mav0/", 1, "/data");
  EXPECT_FALSE(is_uncalibrated(folder_)) << "images alone";
  write("mav0/imu0/data.csv", imu_table());
  for (const fs::path& path : {folder_, folder_ / "mav0"}) {
    ASSERT_TRUE(is_uncalibrated(path));
    const Recording recording = read_uncalibrated(path);
    EXPECT_EQ(recording.name, folder_.filename().string());
    EXPECT_EQ(recording.images->size(), 10u);
    EXPECT_EQ(recording.imu.size(), 115u);
  }
  write("mav0/imu0/sensor.yaml",
        std::string("sensor_type: imu\nT_BS:\n  cols: 4\n  rows: 4\n"
                    "  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n") +
            kNoise);
  EXPECT_TRUE(read_uncalibrated(folder_).imu_noise);
  write("mav0/cam0/sensor.yaml", "sensor_type: camera\n");
  EXPECT_FALSE(is_uncalibrated(folder_));
}

TEST_F(Uncalibrated, TimesAreThoseOfTheList) {
  write_images("", 1, "/data");
  std::string table = "#timestamp [ns],filename\n";
  for (std::int64_t i = 0; i < 10; ++i) {
    table += fmt::format("{},{}.png\n", 1000 + kStart + 50'000'000 * i, kStart + 50'000'000 * i);
  }
  write("cam0/data.csv", table);
  fs::create_directories(folder_ / "imu0");
  ASSERT_TRUE(is_uncalibrated(folder_));
  const Recording recording = read_uncalibrated(folder_);
  EXPECT_TRUE(recording.imu.empty());
  EXPECT_EQ(recording.images->time(0), Time(kStart + 1000));
}

TEST_F(Uncalibrated, SaysWhatIsWrong) {
  write_images("", 1, "");
  write("imu.csv", "timestamp [ns],w_x\n1,2\n");
  EXPECT_THROW(read_uncalibrated(folder_), InputError);
  EXPECT_FALSE(is_uncalibrated(folder_ / "none"));
}

}  // namespace
}  // namespace chasles::test
