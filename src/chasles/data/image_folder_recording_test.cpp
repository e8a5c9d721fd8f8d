#include <chasles/data/image_testing.hpp>
#include <chasles/data/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

const std::string kCalibration = R"(format: chasles-recording-1
name: walk
cameras:
  - resolution: [8, 6]
    intrinsics: [4, 4, 3.5, 2.5]
    distortion_model: none
    cam_T_imu:
      - [1, 0, 0, 0]
      - [0, 1, 0, 0]
      - [0, 0, 1, 0]
      - [0, 0, 0, 1]
imu_convention: interval-mean
)";
const std::string kKalibr = R"(cam0:
  T_cam_imu: [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
  camera_model: pinhole
  distortion_model: none
  distortion_coeffs: []
  intrinsics: [4, 4, 3.5, 2.5]
  resolution: [8, 6]
)";
const char* const kKalibrImu =
    "accelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\n"
    "gyroscope_noise_density: 0.005\ngyroscope_random_walk: 4.0e-06\n";

class ImageFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = test::scratch() / "rec";
    fs::create_directories(folder / "images/cam0");
    test::spill(folder / "calibration.yaml", kCalibration);
    test::spill(folder / "imu.csv", "time_ns,wx,wy,wz,ax,ay,az\n" + test::five_samples());
    for (int k = 0; k < test::kFrames; ++k) {
      test::spill(folder / "images/cam0" / (test::stamp_of(k) + ".png"),
                  test::picture_bytes(test::shade_of(0, k)));
    }
  }
  std::string error() const {
    return input_error([&] { read_recording(folder); });
  }
  fs::path folder;
};

TEST_F(ImageFolder, NamesInNanosecondsAreTheTimes) {
  const Recording r = read_recording(folder);
  EXPECT_EQ(r.name, "walk");
  EXPECT_EQ(r.imu_convention, ImuConvention::kIntervalMean);
  EXPECT_EQ(r.imu.size(), 5u);
  ASSERT_EQ(r.images->size(), 3u);
  EXPECT_EQ(r.images->time(2), std::chrono::milliseconds(15));
  EXPECT_EQ(r.images->read(2).images[0].pixels[0], test::shade_of(0, 2));
  EXPECT_TRUE(r.truth.empty());
}

TEST_F(ImageFolder, ATableOfTimesComesBeforeTheNames) {
  fs::rename(folder / "images/cam0/10000000.png", folder / "images/cam0/second.png");
  test::spill(folder / "images/cam0/times.csv",
              "time_ns,file\n6000000,5000000.png\n9000000,second.png\n");
  test::spill(folder / "truth.tum", "0.005 1 2 3 0 0 0 1\n0.010 1 2 3 0 0 0 1\n");
  const Recording r = read_recording(folder);
  ASSERT_EQ(r.images->size(), 2u);
  EXPECT_EQ(r.images->time(1), std::chrono::milliseconds(9));
  EXPECT_EQ(r.images->read(1).images[0].pixels[0], test::shade_of(0, 1));
  EXPECT_EQ(r.truth.size(), 2u);
}

TEST_F(ImageFolder, KalibrsFilesDoInsteadOfACalibration) {
  fs::remove(folder / "calibration.yaml");
  test::spill(folder / "camchain-imucam.yaml", kKalibr);
  test::spill(folder / "imu.yaml", kKalibrImu);
  const Recording r = read_recording(folder);
  EXPECT_EQ(r.name, "rec");
  EXPECT_EQ(r.cameras[0].cam_T_imu.p.x(), 0.5);
  EXPECT_EQ(r.imu_noise->gyroscope_noise_density, 0.005);
  EXPECT_EQ(r.images->size(), 3u);
}

TEST_F(ImageFolder, ColoursAnd16BitsBecomeGreyAndJpegIsReadAsWell) {
  const cv::Mat grey = test::picture(80);
  cv::Mat deep(6, 8, CV_16UC1), colour(6, 8, CV_8UC3);
  for (int i = 0; i < 48; ++i) {
    const auto shade = grey.at<std::uint8_t>(i / 8, i % 8);
    deep.at<std::uint16_t>(i / 8, i % 8) = static_cast<std::uint16_t>(shade * 257);
    colour.at<cv::Vec3b>(i / 8, i % 8) = {shade, shade, shade};
  }
  const fs::path cam0 = folder / "images/cam0";
  test::spill(cam0 / "5000000.png", test::encoded(deep));
  test::spill(cam0 / "10000000.png", test::encoded(colour));
  fs::remove(cam0 / "15000000.png");
  test::spill(cam0 / "15000000.jpg", test::encoded(grey, ".jpg"));
  const Recording r = read_recording(folder);
  for (std::size_t k = 0; k < 3; ++k) {
    const GrayImage image = r.images->read(k).images[0];
    for (int i = 0; i < 48; ++i) {
      EXPECT_NEAR(image.pixels[static_cast<std::size_t>(i)], 80 + i % 8, k == 2 ? 2 : 0);
    }
  }
}

TEST_F(ImageFolder, HalfAJpegIsNoImage) {
  fs::remove(folder / "images/cam0/15000000.png");
  const std::string bytes = test::encoded(test::picture(9), ".jpg");
  test::spill(folder / "images/cam0/15000000.jpg", bytes.substr(0, bytes.size() - 30));
  const Recording r = read_recording(folder);
  expect_parts(input_error([&] { r.images->read(2); }), {"15000000.jpg", "truncated"});
}

TEST_F(ImageFolder, WhatDoesNotFitIsRefused) {
  fs::create_directories(folder / "images/cam1");
  expect_parts(error(), {"images/cam1", "the calibration has 1 camera only"});
  fs::remove_all(folder / "images/cam1");
  test::spill(folder / "images/cam0/first.png", test::picture_bytes(1));
  expect_parts(error(), {"first.png", "'first'"});
  fs::remove(folder / "images/cam0/first.png");
  test::spill(folder / "calibration.yaml", kCalibration.substr(0, kCalibration.find("imu_conv")));
  expect_parts(error(), {"calibration.yaml", "has no imu_convention"});
  fs::remove(folder / "calibration.yaml");
  expect_parts(error(), {"no calibration.yaml and no camchain-imucam.yaml"});
  test::spill(folder / "calibration.yaml", kCalibration);
  fs::remove(folder / "imu.csv");
  expect_parts(error(), {"imu.csv", "no such file"});
  test::spill(folder / "imu.csv", "time_ns,wx,wy,wz,ax,ay,az\n0,0,0,0,0,0,inf\n");
  expect_parts(error(), {"imu.csv:2", "az", "inf"});
  test::spill(folder / "imu.csv", "time_ns,wx,wy,wz,ax,ay,az\n" + test::five_samples());
  fs::remove_all(folder / "images/cam0");
  expect_parts(error(), {"images/cam0", "no such folder"});
  fs::create_directories(folder / "images/cam0");
  expect_parts(error(), {"images/cam0", "none of the 0 images"});
}

// EuRoC's hundred pairs, linked into an image folder: their names are TIME_CAMERA.jpg.
TEST(RealImageFolder, TheSparseStereoPairsAreDecoded) {
  const auto kitti = test::recordings();
  if (!kitti) GTEST_SKIP() << "skipped: no recordings";
  const fs::path folder = test::scratch();
  std::string calibration = kCalibration;
  calibration.replace(calibration.find("[8, 6]"), 6, "[752, 480]");
  const std::size_t begin = calibration.find("  - res"), end = calibration.find("imu_conv");
  calibration.insert(end, calibration.substr(begin, end - begin));
  test::spill(folder / "calibration.yaml", calibration);
  test::spill(folder / "imu.csv", "time_ns,wx,wy,wz,ax,ay,az\n" + test::five_samples());
  for (int c = 0; c < 2; ++c) fs::create_directories(folder / fmt::format("images/cam{}", c));
  const fs::path pairs = kitti->parent_path() / "euroc/V1_01_easy_sparse_stereo";
  for (const auto& entry : fs::directory_iterator(pairs)) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with(".jpg")) continue;
    const std::size_t cut = name.find('_');
    fs::create_symlink(
        fs::absolute(entry.path()),
        folder / "images" / ("cam" + name.substr(cut + 1, 1)) / (name.substr(0, cut) + ".jpg"));
  }
  const Recording r = read_recording(folder);
  ASSERT_EQ(r.images->size(), 100u);
  for (const std::size_t k : {0u, 57u, 99u}) {
    const ImageFrame frame = r.images->read(k);
    EXPECT_EQ(frame.images[0].pixels.size(), 752u * 480u);
    EXPECT_EQ(frame.images[1].pixels.size(), 752u * 480u);
    EXPECT_NE(frame.images[0].pixels, frame.images[1].pixels);
  }
}

}  // namespace
}  // namespace chasles
