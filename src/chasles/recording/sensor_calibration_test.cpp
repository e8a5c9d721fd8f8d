#include <cmath>

#include <chasles/bags/bag_testing.hpp>
#include <chasles/calibration/imu_range.hpp>
#include <chasles/recording/apply_calibration.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/sensor_calibration.hpp>

// What a driver's calibration is, against the recordings that the same files calibrate.
namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;
using test::scratch;
using test::spill;

const char* const kOwnFile =
    "format: chasles-recording-1\nname: own\ncameras:\n  - resolution: [8, 6]\n"
    "    intrinsics: [4, 4, 3.5, 2.5]\n    distortion_model: none\n"
    "    cam_T_imu: [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
    "    timeshift_cam_imu: 0.25\nimu_convention: interval-mean\nsingle_pixel_sigma: 0.75\n"
    "accelerometer_range: 80\n";
const char* const kOwnNoise =
    "accelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\n"
    "gyroscope_noise_density: 0.005\ngyroscope_random_walk: 4.0e-06\n";

void expect_like(const SensorCalibration& found, const Recording& recording) {
  ASSERT_EQ(found.cameras.size(), recording.cameras.size());
  for (std::size_t c = 0; c < found.cameras.size(); ++c) {
    EXPECT_EQ(found.cameras[c].fx, recording.cameras[c].fx);
    EXPECT_EQ(found.cameras[c].cam_T_imu.p, recording.cameras[c].cam_T_imu.p);
    EXPECT_EQ(found.cameras[c].cam_T_imu.R, recording.cameras[c].cam_T_imu.R);
  }
  EXPECT_EQ(found.imu_noise.gyroscope_random_walk, recording.imu_noise->gyroscope_random_walk);
  EXPECT_EQ(found.imu_convention, recording.imu_convention);
  EXPECT_EQ(found.exact_calibration, recording.exact_calibration);
  EXPECT_EQ(found.imu_range.gyroscope, recording.imu_range.gyroscope);
}

// The bag of the readers' tests beside these files.
Recording bag_beside(const fs::path& folder) {
  fs::copy_file(test::written_bag("none.bag"), folder / "none.bag");
  return read_recording(folder / "none.bag");
}

TEST(SensorCalibration, OfKalibrIsThatOfABag) {
  const fs::path folder = scratch();
  test::write_kalibr(folder);
  const Recording bag = bag_beside(folder);
  expect_like(read_sensor_calibration(folder), bag);
  expect_like(read_sensor_calibration(folder / "camchain-imucam.yaml"), bag);
  EXPECT_EQ(read_sensor_calibration(folder, 1).cameras.size(), 1u);
}

TEST(SensorCalibration, KnowsTheTopicsThatKalibrNames) {
  const fs::path folder = scratch();
  spill(folder / "camchain-imucam.yaml", test::kalibr_chain("/left", "/right"));
  spill(folder / "imu.yaml", std::string(test::kKalibrImu) + "rostopic: /imu\n");
  const SensorCalibration found = read_sensor_calibration(folder);
  EXPECT_EQ(found.camera_topics, (std::vector<std::string>{"/left", "/right"}));
  EXPECT_EQ(found.imu_topic, "/imu");
}

TEST(SensorCalibration, OfAnImuAloneHasNoCamera) {
  const fs::path folder = scratch();
  spill(folder / "imu.yaml", std::string(test::kKalibrImu) + "gyroscope_range: 17\n");
  for (const fs::path& path : {folder, folder / "imu.yaml"}) {
    const SensorCalibration found = read_sensor_calibration(path);
    EXPECT_TRUE(found.cameras.empty());
    EXPECT_EQ(found.imu_noise.gyroscope_noise_density, 0.005);
    EXPECT_EQ(found.imu_range.gyroscope, 17);
  }
}

TEST(SensorCalibration, OfTheProjectsOwnFile) {
  const fs::path folder = scratch();
  spill(folder / "calibration.yaml", std::string(kOwnFile) + kOwnNoise);
  for (const fs::path& path : {folder, folder / "calibration.yaml"}) {
    const SensorCalibration found = read_sensor_calibration(path);
    ASSERT_EQ(found.cameras.size(), 1u);
    EXPECT_EQ(found.cameras[0].cam_T_imu.p.x(), 0.5);
    EXPECT_EQ(found.time_offsets, std::vector<Time>{from_seconds(0.25)});
    EXPECT_EQ(found.camera_topics, std::vector<std::string>{""});
    EXPECT_EQ(found.imu_convention, ImuConvention::kIntervalMean);
    EXPECT_EQ(found.single_pixel_sigma, 0.75);
    EXPECT_EQ(found.imu_range.accelerometer, 80);
  }
}

TEST(SensorCalibration, OfAnEurocFolderIsThatOfItsRecording) {
  const fs::path folder = scratch();
  test::write_euroc_folder(folder, 2);
  const Recording recording = read_recording(folder);
  expect_like(read_sensor_calibration(folder), recording);
  expect_like(read_sensor_calibration(folder / "mav0"), recording);
}

TEST(SensorCalibration, WhatIsNoneSaysWhatIsExpected) {
  const fs::path folder = scratch();
  const auto error_of = [](const fs::path& path) {
    return input_error([&] { read_sensor_calibration(path); });
  };
  expect_parts(error_of(folder / "none"), {"none: there is no such file", "expected Kalibr's"});
  expect_parts(error_of(folder), {"holds no calibration", "expected Kalibr's"});
  spill(folder / "other.yaml", "size: 7\n");
  expect_parts(error_of(folder / "other.yaml"), {"other.yaml: is no calibration"});
  spill(folder / "camchain.yaml", test::kalibr_chain());
  expect_parts(error_of(folder / "camchain.yaml"), {"camchain.yaml: there is no imu.yaml beside"});
  spill(folder / "calibration.yaml", kOwnFile);
  expect_parts(error_of(folder / "calibration.yaml"),
               {"has 1 cameras and no noise of an IMU", "accelerometer_noise_density"});
}

// One by one as all of a recording together.
TEST(SensorCalibration, CorrectsSamplesAsARecordingsAre) {
  SensorCalibration calibration;
  calibration.imu_intrinsics = ImuIntrinsics{};
  calibration.imu_intrinsics->force(0, 1) = 0.01;
  calibration.imu_intrinsics->rate(2, 2) = 1.02;
  calibration.imu_intrinsics->rate_of_force(1, 0) = 1e-3;
  calibration.imu_range = {.accelerometer = 78.4, .gyroscope = 17};
  Recording recording;
  recording.imu_range = calibration.imu_range;
  for (int k = 0; k < 4; ++k) {
    recording.imu.push_back({.time = Time(k),
                             .specific_force_imu = {1.0 + k, -2, 9.8 + 30 * k},
                             .angular_rate_imu = {0.1, 6.0 * k, 0.3}});
  }
  const std::vector<ImuSample> measured = recording.imu;
  correct_samples(*calibration.imu_intrinsics, recording);
  for (std::size_t k = 0; k < measured.size(); ++k) {
    const ImuSample one = corrected_sample(calibration, measured[k]);
    EXPECT_EQ(one.specific_force_imu, recording.imu[k].specific_force_imu);
    EXPECT_EQ(one.angular_rate_imu, recording.imu[k].angular_rate_imu);
    EXPECT_EQ(one.force_clipped, recording.imu[k].force_clipped);
    EXPECT_EQ(one.rate_clipped, recording.imu[k].rate_clipped);
  }
  EXPECT_TRUE(recording.imu.back().force_clipped && recording.imu.back().rate_clipped);
  const ImuRange range = corrected_range(calibration);
  EXPECT_EQ(range.accelerometer, recording.imu_range.accelerometer);
  EXPECT_GE(range.gyroscope, recording.imu_range.gyroscope);  // what any force could add
  calibration.imu_range.accelerometer = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(std::isfinite(corrected_range(calibration).gyroscope));
}

TEST(SensorCalibration, WithoutIntrinsicsSamplesAreAsMeasured) {
  SensorCalibration calibration;
  calibration.imu_range.gyroscope = 17;
  const ImuSample sample{.time = Time(1), .angular_rate_imu = {20, 0, 0}};
  EXPECT_EQ(corrected_sample(calibration, sample).angular_rate_imu, sample.angular_rate_imu);
  EXPECT_FALSE(corrected_sample(calibration, sample).rate_clipped);  // the estimator's own range
  EXPECT_EQ(corrected_range(calibration).gyroscope, 17);
}

}  // namespace
}  // namespace chasles
