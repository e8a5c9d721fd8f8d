#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/image_views.hpp>
#include <chasles/recording/readers.hpp>

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

TEST_F(ImageFolder, NamesAreInTheOrderOfTheirNumbersAndHiddenFilesAreLeftOut) {
  const fs::path cam0 = folder / "images/cam0";
  test::spill(cam0 / "._5000000.png", "Mac OS X");
  test::spill(cam0 / ".DS_Store", "");
  test::spill(cam0 / "Thumbs.db", "");
  fs::rename(cam0 / "10000000.png", cam0 / "10000000.PNG");
  const Recording r = read_recording(folder);
  ASSERT_EQ(r.images->size(), 3u);
  EXPECT_EQ(r.images->read(1).images[0].pixels[0], test::shade_of(0, 1));
  for (const std::string& remark : r.remarks) {
    EXPECT_EQ(remark.find("came after later"), std::string::npos) << remark;
  }
}

TEST_F(ImageFolder, ATableMayNameItsFilesFromAnyFolderOfTheRecording) {
  test::spill(folder / "images/cam0/times.csv",
              "time_ns,file\n5000000,images/cam0/5000000.png\n6000000,cam0/10000000.png\n"
              "7000000,/home/me/walk/cam0/15000000.png\n8000000,images\\cam0\\15000000.png\n"
              "9000000,images/cam0/lost.png\n9500000,../../imu.csv\n");
  const Recording r = read_recording(folder);
  ASSERT_EQ(r.images->size(), 4u);
  for (const std::size_t k : {0u, 1u, 2u, 3u}) {
    EXPECT_EQ(r.images->read(k).images[0].pixels[0],
              test::shade_of(0, static_cast<int>(std::min<std::size_t>(k, 2))));
  }
  ASSERT_EQ(r.remarks.size(), 1u);
  expect_parts(r.remarks[0], {"2 of 6 images of cam0 are listed, but are not in its folder"});
  test::spill(folder / "images/cam0/times.csv", "time_ns,file\n5000000,right/0.png\n");
  expect_parts(error(), {"none of the 1 images of cam0 is there, such as", "cam0/right/0.png",
                         "expected PNG, JPEG, PGM, BMP, TIFF or WebP files"});
}

// Twelve bits in 16, as drivers of machine vision cameras write them; the first image is dark.
TEST_F(ImageFolder, TheRangeOfDeepImagesIsOneForTheRecording) {
  const auto write = [&](int k, int shade) {
    const cv::Mat image(6, 8, CV_16UC1, cv::Scalar(shade));
    test::spill(folder / "images/cam0" / (test::stamp_of(k) + ".png"), test::encoded(image));
  };
  const auto shade = [&](const Recording& r, std::size_t k) {
    return int{r.images->read(k).images[0].pixels[0]};
  };
  write(0, 160);
  write(1, 4000);
  write(2, 2000);
  const Recording r = read_recording(folder);
  EXPECT_EQ(shade(r, 0), 160 / 16);
  EXPECT_EQ(shade(r, 1), 4000 / 16);
  EXPECT_EQ(shade(r, 2), 2000 / 16);
  ASSERT_EQ(r.remarks.size(), 1u);
  expect_parts(r.remarks[0], {"the images of cam0 have 16 bits and use 12 of them", "4000"});
  write(1, 60000);  // the whole range: the high byte
  EXPECT_EQ(shade(read_recording(folder), 2), 2000 / 256);
  test::spill(folder / "images/cam0/5000000.png", "torn");  // the others decide
  EXPECT_EQ(shade(read_recording(folder), 1), 60000 / 256);
}

TEST_F(ImageFolder, OnlyTheAskedForCamerasAreDecoded) {
  test::write_euroc_folder(folder / "stereo", 2);
  for (int k = 0; k < test::kFrames; ++k) {
    test::spill(folder / "stereo/mav0/cam1/data" / (test::stamp_of(k) + ".png"), "torn");
  }
  const Recording r = read_recording(folder / "stereo");
  const auto first = part_of(r.images, r.images->time(0), r.images->time(2), 1);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(first->read(k).images.size(), 1u);
    EXPECT_EQ(first->read(k).images[0].pixels[0], test::shade_of(0, static_cast<int>(k)));
    EXPECT_EQ(r.images->read_cameras(k, 1).images.size(), 1u);
    EXPECT_THROW(r.images->read(k), InputError);
  }
}

TEST_F(ImageFolder, HalfAJpegIsNoImage) {
  fs::remove(folder / "images/cam0/15000000.png");
  const std::string bytes = test::encoded(test::picture(9), ".jpg");
  test::spill(folder / "images/cam0/15000000.jpg", bytes.substr(0, bytes.size() - 30));
  const Recording r = read_recording(folder);
  expect_parts(input_error([&] { r.images->read(2); }), {"15000000.jpg", "truncated"});
}

// The cameras of a rig are triggered together: one list of times serves both.
TEST_F(ImageFolder, TheListOfTheFirstCameraServesTheOthers) {
  fs::remove(folder / "calibration.yaml");
  std::string second = kKalibr;
  second.replace(0, 4, "cam1");
  test::spill(folder / "camchain-imucam.yaml", kKalibr + second);
  test::spill(folder / "imu.yaml", kKalibrImu);
  fs::rename(folder / "images/cam0", folder / "image_0");
  fs::remove(folder / "images");
  for (int k = 0; k < test::kFrames; ++k) {
    fs::rename(folder / "image_0" / (test::stamp_of(k) + ".png"),
               folder / "image_0" / fmt::format("{:06}.png", k));
  }
  fs::copy(folder / "image_0", folder / "image_1");
  fs::rename(folder / "imu.csv", folder / "imuData.csv");
  expect_parts(error(), {"image_0: the names of its 3 images", "no list"});
  test::spill(folder / "image_0/times.txt", "0 0.005\n1 0.010\n2 0.015\n");
  const Recording r = read_recording(folder);
  EXPECT_EQ(r.cameras.size(), 2u);
  ASSERT_EQ(r.images->size(), 3u);
  EXPECT_EQ(r.images->time(2), std::chrono::milliseconds(15));
  EXPECT_EQ(r.images->read(2).images.size(), 2u);
}

std::string all_of(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

// Each camera has a clock of its own: the stamps of the second differ by 20 ms from the first's.
TEST_F(ImageFolder, StampsAreMovedToTheImusClockBeforeTheyArePaired) {
  fs::remove(folder / "calibration.yaml");
  std::string second = kKalibr;
  second.replace(0, 4, "cam1");
  test::spill(folder / "camchain-imucam.yaml", kKalibr + "  timeshift_cam_imu: -0.002\n" + second +
                                                   "  timeshift_cam_imu: -0.0221\n");
  test::spill(folder / "imu.yaml", kKalibrImu);
  fs::create_directories(folder / "images/cam1");
  for (int k = 0; k < test::kFrames; ++k) {
    test::spill(folder / fmt::format("images/cam1/{}.png", 25'000'000 + k * 5'000'000),
                test::picture_bytes(test::shade_of(1, k)));
  }
  const Recording r = read_recording(folder);
  ASSERT_EQ(r.images->size(), 3u);
  for (int k = 0; k < test::kFrames; ++k) {
    const auto i = static_cast<std::size_t>(k);
    EXPECT_EQ(r.images->time(i), std::chrono::milliseconds(5 * (k + 1) - 2));
    EXPECT_EQ(r.images->read(i).images[0].pixels[0], test::shade_of(0, k));
    EXPECT_EQ(r.images->read(i).images[1].pixels[0], test::shade_of(1, k));
  }
  expect_parts(all_of(r.remarks), {"cam0 are 2.000 ms late", "cam1 are 22.100 ms late"});
}

TEST_F(ImageFolder, TheOwnCalibrationStatesATimeOffsetToo) {
  std::string text = kCalibration;
  const std::string key = "    timeshift_cam_imu: 0.003\n";
  test::spill(folder / "calibration.yaml", text.insert(text.find("imu_conv"), key));
  const Recording r = read_recording(folder);
  EXPECT_EQ(r.images->time(0), std::chrono::milliseconds(8));
  expect_parts(all_of(r.remarks), {"cam0 are 3.000 ms early"});
}

TEST_F(ImageFolder, TheImusIntrinsicsCorrectTheSamples) {
  fs::remove(folder / "calibration.yaml");
  test::spill(folder / "camchain-imucam.yaml", kKalibr);
  test::spill(folder / "imu.yaml", std::string(kKalibrImu) +
                                       "Ta: [[2, 0, 0], [0, 1, 0], [0, 0, 1]]\n"
                                       "Tw: [[1, 0, 0], [0, 1, 0], [0, 0, 4]]\n");
  const Recording r = read_recording(folder);
  EXPECT_EQ(r.imu[4].specific_force_imu, Eigen::Vector3d(0.5, 2, 9.5));
  EXPECT_EQ(r.imu[4].angular_rate_imu, Eigen::Vector3d(0.1, 0.2, 1));
  expect_parts(all_of(r.remarks), {"corrected by the IMU's intrinsics"});
}

// kalibr_bagextractor's folder.
TEST_F(ImageFolder, TheImagesMayBeBesideTheCalibration) {
  fs::rename(folder / "images/cam0", folder / "cam0");
  fs::remove(folder / "images");
  fs::remove(folder / "imu.csv");
  test::spill(folder / "imu0.csv",
              "timestamp,omega_x,omega_y,omega_z,alpha_x,alpha_y,alpha_z\n" + test::five_samples());
  const Recording r = read_recording(folder);
  EXPECT_EQ(r.imu.size(), 5u);
  EXPECT_EQ(r.images->read(1).images[0].pixels[0], test::shade_of(0, 1));
}

TEST_F(ImageFolder, TablesOfWindowsProgramsAndScriptsAreRead) {
  test::spill(folder / "imu.csv",
              "\xef\xbb\xbf"
              "time_ns,wx,wy,wz,ax,ay,az\r\n0,0,0,0,0,0,9\r\n20000000,0,0,0,0,0,9");
  test::spill(folder / "images/cam0/times.csv",
              "\xef\xbb\xbf#timestamp [ns],filename\r\n6000000,images/cam0/5000000.png");
  test::spill(folder / "calibration.yaml",
              "\xef\xbb\xbf" + kCalibration.substr(0, kCalibration.size() - 1));
  const Recording r = read_recording(folder);
  EXPECT_EQ(r.imu.size(), 2u);
  ASSERT_EQ(r.images->size(), 1u);
  EXPECT_EQ(r.images->time(0), std::chrono::milliseconds(6));
  EXPECT_EQ(r.images->read(0).images[0].pixels[0], test::shade_of(0, 0));
}

// A second camera that is calibrated, or has images, but not both.
TEST_F(ImageFolder, ACameraWithoutItsOtherHalfIsLeftOutAndSaid) {
  fs::create_directories(folder / "images/cam1");
  test::spill(folder / "images/cam1/5000000.png", test::encoded(test::picture(3, 4, 4)));
  Recording r = read_recording(folder);
  EXPECT_EQ(r.cameras.size(), 1u);
  expect_parts(all_of(r.remarks), {"cam1 is not read: the calibration has 1 camera"});
  fs::remove_all(folder / "images/cam1");
  std::string two = kCalibration;
  const std::size_t begin = two.find("  - res"), end = two.find("imu_conv");
  test::spill(folder / "calibration.yaml", two.insert(end, two.substr(begin, end - begin)));
  r = read_recording(folder);
  EXPECT_EQ(r.cameras.size(), 1u);
  EXPECT_EQ(r.images->read(0).images.size(), 1u);
  expect_parts(all_of(r.remarks), {"cam1 is calibrated, but has no images: left out"});
}

// With one camera asked for, whatever the second one's files are.
TEST_F(ImageFolder, CamerasThatAreNotAskedForAreNotRead) {
  std::string two = kCalibration;
  const std::size_t begin = two.find("  - res"), end = two.find("imu_conv");
  test::spill(folder / "calibration.yaml", two.insert(end, two.substr(begin, end - begin)));
  test::spill(folder / "images/cam1", "not a folder");
  const Recording r = read_recording(folder, {.cameras = 1});
  EXPECT_EQ(r.cameras.size(), 1u);
  EXPECT_EQ(r.images->size(), 3u);
  EXPECT_EQ(all_of(r.remarks).find("cam1"), std::string::npos) << all_of(r.remarks);
  fs::remove(folder / "images/cam1");
  fs::create_directories(folder / "images/cam1");
  test::spill(folder / "images/cam1/first.png", "no number, no image");
  EXPECT_EQ(read_recording(folder, {.cameras = 1}).images->read(0).images.size(), 1u);
  expect_parts(error(), {"first.png", "'first'"});
}

TEST_F(ImageFolder, ACalibrationOfAnotherSizeIsFoundAtOnce) {
  std::string text = kCalibration;
  test::spill(folder / "calibration.yaml", text.replace(text.find("[8, 6]"), 6, "[4, 3]"));
  expect_parts(error(), {"5000000.png", "8 x 6", "4 x 3", "take a calibration of this size"});
  // A damaged image does not show the size, and the next one does.
  test::spill(folder / "images/cam0/5000000.png", "half");
  expect_parts(error(), {"10000000.png", "8 x 6"});
}

TEST_F(ImageFolder, WhatDoesNotFitIsRejected) {
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
  expect_parts(error(), {"imu.csv", "none of the 1 IMU samples"});
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
  // Its samples are not those of the images' time, which read_recording() would reject.
  const Recording r = read_image_folder_recording(folder);
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
