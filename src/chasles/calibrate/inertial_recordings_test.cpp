#include <algorithm>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/inertial_report.hpp>
#include <chasles/calibrate/inertial_testing.hpp>

// Parts of a calibration with an IMU: halves of a recording, and several recordings.
namespace chasles::test {
namespace {

TEST(InertialHalves, DifferWithinTheirSigmas) {
  BoardRigScene scene{.cameras = mounted(1, 0.01), .time_offset = 0.02, .seconds = 16};
  const InertialCalibrationInput input = inertial_views(scene, 6);
  const InertialCalibration found = calibrate_inertial(input);
  const InertialHalves halves = compare_halves(input, found);
  const Eigen::ArrayXd ratios = halves.difference.array() / halves.sigma.array();
  EXPECT_LT(ratios.abs().maxCoeff(), 4);
  EXPECT_GT(ratios.square().mean(), 0.1);
  EXPECT_LT(ratios.square().mean(), 2.5);
  // Each half has less to say than both.
  const Eigen::ArrayXd sigmas = found.covariance.diagonal().array().sqrt();
  EXPECT_TRUE((halves.sigma.array() > 1.4 * sigmas).all());
  EXPECT_GT(halves.pixels[0], 0);
  EXPECT_LT(halves.pixels[0], 3 * halves.pixels_sigma[0]);
}

TEST(InertialHalves, NeedTime) {
  const BoardRigScene scene{.cameras = mounted(1), .seconds = 5};
  const InertialCalibrationInput input = inertial_views(scene, 6);
  const InertialCalibration found = calibrate_inertial(input);
  try {
    compare_halves(input, found);
    ADD_FAILURE() << "5 s";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("over 5.0 s, expected 12 s"), std::string::npos)
        << error.what();
  }
}

// The board is moved between the recordings, and the biases are others.
TEST(InertialRecordings, EachHasItsOwnGravity) {
  BoardRigScene scene{.cameras = mounted(1), .time_offset = 0.02, .seconds = 6};
  const InertialCalibrationInput first = inertial_views(scene, 7);
  scene.recording = 1;
  const InertialCalibrationInput second = inertial_views(scene, 8);
  InertialCalibrationInput both = first;
  add_recording(both, second.cameras.views, second.imu);
  ASSERT_EQ(both.recordings(), 2u);
  EXPECT_EQ(both.imu.size(), first.imu.size() + second.imu.size());
  EXPECT_TRUE(std::ranges::is_sorted(both.imu, {}, &ImuSample::time));
  EXPECT_EQ(both.recording_of(first.imu.back().time), 0u);
  EXPECT_EQ(both.recording_of(both.cameras.views.back().time), 1u);

  const InertialCalibration found = calibrate_inertial(both), alone = calibrate_inertial(first);
  const Eigen::VectorXd errors = inertial_errors(found, scene);
  const double nees = errors.dot(found.covariance.ldlt().solve(errors));
  EXPECT_LT(nees / static_cast<double>(errors.size()), 1.8);
  EXPECT_GT(nees / static_cast<double>(errors.size()), 0.3);
  EXPECT_NEAR(found.seconds, 2 * alone.seconds, 0.1) << "without the pause";
  EXPECT_EQ(found.names[static_cast<std::size_t>(found.layout.gravity_row(1))],
            "recording1.gravity_1");
  for (const int row : {found.layout.lens_row(0), found.layout.offset_row(0)}) {
    EXPECT_LT(found.covariance(row, row), 0.75 * alone.covariance(row, row)) << row;
  }
  EXPECT_TRUE(contradictions(found).empty());
  both.borders.clear();
  EXPECT_FALSE(contradictions(calibrate_inertial(both)).empty()) << "one gravity for both";
}

TEST(InertialRecordings, SaysWhichOneHasNoCommonTime) {
  const BoardRigScene scene{.cameras = mounted(1), .seconds = 5};
  InertialCalibrationInput both = inertial_views(scene, 9);
  InertialCalibrationInput late = both;
  for (ImuSample& sample : late.imu) sample.time += std::chrono::seconds(100);
  add_recording(both, late.cameras.views, late.imu);
  try {
    calibrate_inertial(both);
    ADD_FAILURE() << "no samples of the second recording's views";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("recording 2 of 2: the IMU covers none"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace chasles::test
