#include <algorithm>

#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

/// Four lines in times.txt, of which the second image was lost; the pair is 0.54 m apart.
class KittiOdometry : public ::testing::Test {
 protected:
  void SetUp() override {
    sequence = test::scratch() / "00";
    for (int c = 0; c < 2; ++c) {
      const fs::path camera = sequence / fmt::format("image_{}", c);
      fs::create_directories(camera);
      for (const int k : {0, 2, 3}) {
        test::spill(camera / fmt::format("{:06}.png", k), test::picture_bytes(10 + 100 * c + k));
      }
    }
    test::spill(sequence / "times.txt", "0.000000e+00\n\n1.037e-02\n0.015\n");
    test::spill(sequence / "calib.txt",
                "P0: 4 0 3.5 0 0 4 2.5 0 0 0 1 0\nP1: 4 0 3.5 -2.16 0 4 2.5 0 0 0 1 0\n");
  }
  void add_imu() const {
    test::spill(sequence / "imu.csv", "time_ns,wx,wy,wz,ax,ay,az\n" + test::five_samples());
    test::spill(sequence / "imu.yaml",
                "accelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\n"
                "gyroscope_noise_density: 0.005\ngyroscope_random_walk: 4.0e-06\n"
                "T_cam_imu: [[0, -1, 0, 0.1], [0, 0, -1, 0.2], [1, 0, 0, 0.3], [0, 0, 0, 1]]\n"
                "timeshift_cam_imu: 0.001\n");
  }
  std::string error() const {
    return input_error([&] { read_recording(sequence); });
  }
  fs::path sequence;
};

TEST_F(KittiOdometry, WithoutInertialDataItSaysWhatIsMissing) {
  expect_parts(error(), {"KITTI odometry", "without inertial data", "Put both beside calib.txt",
                         "T_cam_imu"});
  add_imu();
  fs::remove(sequence / "imu.yaml");
  expect_parts(error(), {"Put imu.yaml beside"});
  add_imu();
  fs::remove(sequence / "imu.csv");
  expect_parts(error(), {"Put imu.csv beside"});
}

TEST_F(KittiOdometry, WithInertialDataBesideItIsARecording) {
  add_imu();
  test::spill(sequence / "truth.tum", "0.005 1 2 3 0 0 0 1\n0.010 1 2 3 0 0 0 1\n");
  const Recording r = read_recording(sequence);
  EXPECT_EQ(r.name, "00");
  ASSERT_EQ(r.cameras.size(), 2u);
  EXPECT_EQ(r.cameras[0].width, 8);
  EXPECT_EQ(r.cameras[1].cy, 2.5);
  EXPECT_LT((r.cameras[0].cam_T_imu.p - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-15);
  const SE3 cam1_T_cam0 = r.cameras[1].cam_T_imu * r.cameras[0].cam_T_imu.inverse();
  EXPECT_LT((cam1_T_cam0.p - Eigen::Vector3d(-0.54, 0, 0)).norm(), 1e-12);
  ASSERT_EQ(r.images->size(), 3u);
  EXPECT_EQ(r.images->time(1), std::chrono::microseconds(11370));
  EXPECT_EQ(r.images->read(1).images[1].pixels[0], 112) << "the third line's image";
  EXPECT_EQ(r.imu.size(), 5u);
  EXPECT_EQ(r.truth.size(), 2u);
  EXPECT_EQ(read_recording(sequence, {.cameras = 1}).images->read(0).images.size(), 1u);
}

TEST_F(KittiOdometry, OtherFilesAndSecondFormsOfAnImageAreLeftOut) {
  add_imu();
  for (const char* name : {"000000.txt", "000002.yaml", "._000003.png", "2"}) {
    test::spill(sequence / "image_0" / name, "no image");
  }
  test::spill(sequence / "image_0/000002.tif", test::encoded(test::picture(200), ".tif"));
  const Recording r = read_recording(sequence);
  ASSERT_EQ(r.images->size(), 3u);
  EXPECT_EQ(r.images->read(0).images[0].pixels[0], 10);
  EXPECT_EQ(r.images->read(1).images[0].pixels[0], 12) << "the first by its name";
  EXPECT_EQ(r.images->read(2).images[0].pixels[0], 13);
  EXPECT_TRUE(std::ranges::any_of(r.remarks, [](const std::string& remark) {
    return remark.find("1 of 4 images of cam0 repeat the time") != std::string::npos;
  }));
}

TEST_F(KittiOdometry, TimesAndImagesThatDoNotMatchAreCounted) {
  add_imu();
  for (const std::string& remark : read_recording(sequence).remarks) {
    EXPECT_EQ(remark.find("times.txt"), std::string::npos) << remark;
  }
  test::spill(sequence / "times.txt", "0\n0.005\n0.010\n");
  const Recording r = read_recording(sequence);
  const auto counted = [&](const std::string& camera) {
    return std::ranges::any_of(r.remarks, [&](const std::string& remark) {
      return remark.starts_with(camera + " has 3 images, and times.txt 3 times: 2 images have one");
    });
  };
  EXPECT_TRUE(counted("image_0"));
  EXPECT_TRUE(counted("image_1"));
}

TEST_F(KittiOdometry, ImagesOfAnotherSizeThanTheCalibrationsAreRejected) {
  add_imu();
  test::spill(sequence / "calib.txt",
              "P0: 8 0 7 0 0 8 5 0 0 0 1 0\nP1: 8 0 7 -4.32 0 8 5 0 0 0 1 0\n");
  expect_parts(error(), {"calib.txt: P0", "(7.0, 5.0)", "8 x 6 pixels"});
}

TEST_F(KittiOdometry, FilesThatDoNotFitAreNamed) {
  add_imu();
  test::spill(sequence / "times.txt", "0\nten\n");
  expect_parts(error(), {"times.txt:2", "ten"});
  test::spill(sequence / "times.txt", "");
  expect_parts(error(), {"image_0", "no image"});
  test::spill(sequence / "times.txt", "0\n0.1\n0.2\n0.3\n");
  test::spill(sequence / "calib.txt", "P0: 4 0 3.5 0 0 4 2.5 0 0 0 1\n");
  expect_parts(error(), {"calib.txt: key 'P0'", "holds 11 numbers, expected 12"});
  test::spill(sequence / "imu.yaml", "T_cam_body: 1\n");
  expect_parts(error(), {"imu.yaml", "T_cam_imu"});
}

}  // namespace
}  // namespace chasles
