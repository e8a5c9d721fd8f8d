#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/calibrate/inertial_report.hpp>
#include <chasles/calibrate/inertial_testing.hpp>
#include <chasles/calibrate/rotation_alignment.hpp>

namespace chasles::test {
namespace {

TEST(InertialCalibration, ErrorsAreThoseOfTheirCovariance) {
  double nees = 0, rows = 0, beyond = 0;
  for (const auto& [count, readout, offset] :
       {std::tuple(1u, 0.0, 0.0), {2u, 0.0, -0.1}, {1u, 0.02, 0.1}, {2u, 0.015, 0.012}}) {
    for (std::uint64_t run = 0; run < 2; ++run) {
      BoardRigScene scene{.cameras = mounted(count, readout), .time_offset = offset};
      scene.imu.force.diagonal() << 0.004, -0.003, 0.002;
      scene.imu.rate << 0.003, 0.001, -0.002, 0.0015, -0.004, 0.001, -0.001, 0.002, 0.002;
      const InertialCalibration found = calibrate_inertial(inertial_views(scene, run));
      const Eigen::VectorXd errors = inertial_errors(found, scene);
      const double one = errors.dot(found.covariance.ldlt().solve(errors));
      const Eigen::VectorXd sigmas = found.covariance.diagonal().cwiseSqrt();
      nees += one;
      rows += static_cast<double>(errors.size());
      beyond += static_cast<double>((errors.array().abs() > 3 * sigmas.array()).count());
      EXPECT_NEAR(found.pixel_sigma, scene.pixel_sigma, 0.005);
      EXPECT_LT(found.gyroscope_factor, 1.1);
      EXPECT_LT(found.accelerometer_factor, 1.1);
    }
  }
  EXPECT_LT(nees / rows, 1.6);
  EXPECT_GT(nees / rows, 0.4);
  EXPECT_LE(beyond, 0.02 * rows);
}

std::string fault_of(const InertialCalibrationInput& input) {
  try {
    calibrate_inertial(input);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(InertialCalibration, SaysWhatDoesNotFit) {
  const BoardRigScene scene{.cameras = mounted(1), .seconds = 6};
  InertialCalibrationInput input = inertial_views(scene, 1);
  InertialCalibrationInput degrees = input;
  for (ImuSample& sample : degrees.imu) sample.angular_rate_imu *= kDegrees;
  EXPECT_NE(fault_of(degrees).find("does not turn as the cameras do"), std::string::npos)
      << fault_of(degrees);
  InertialCalibrationInput late = input;
  for (ImuSample& sample : late.imu) sample.time += std::chrono::seconds(100);
  EXPECT_NE(fault_of(late).find("too little time in common"), std::string::npos) << fault_of(late);
  input.imu.clear();
  EXPECT_NE(fault_of(input).find("found 0 IMU samples"), std::string::npos);
}

TEST(InertialCalibration, SaysWhichSensorIsTurnedAndWhichCameraIsLate) {
  const BoardRigScene scene{.cameras = mounted(2), .seconds = 5, .frame_rate = 10};
  const InertialCalibrationInput input = inertial_views(scene, 1);
  InertialCalibrationInput upside_down = input;
  for (ImuSample& sample : upside_down.imu) sample.specific_force_imu *= -1;
  EXPECT_NE(fault_of(upside_down).find("accelerometer has the other sign"), std::string::npos)
      << fault_of(upside_down);
  InertialCalibrationInput mirrored = input;
  for (ImuSample& sample : mirrored.imu) sample.angular_rate_imu.y() *= -1;
  EXPECT_NE(fault_of(mirrored).find("turns the other way round"), std::string::npos)
      << fault_of(mirrored);
  for (const int frames : {1, -2}) {
    InertialCalibrationInput late = input;
    for (TargetView& view : late.cameras.views) {
      if (view.camera == 1) view.time += frames * std::chrono::milliseconds(100);
    }
    const std::string expected =
        frames > 0 ? "cam1 is 1 frame (0.100 s) late against cam0" : "cam0 is 2 frames (0.200 s)";
    EXPECT_NE(fault_of(late).find(expected), std::string::npos) << fault_of(late);
  }
}

TEST(InertialCalibration, ATargetOfAnotherSizeContradictsTheAccelerometer) {
  const BoardRigScene scene{.cameras = mounted(1), .seconds = 8};
  InertialCalibrationInput input = inertial_views(scene, 2);
  EXPECT_TRUE(contradictions(calibrate_inertial(input)).empty());
  InertialCalibrationInput larger = input;
  for (Eigen::Vector3d& corner : larger.cameras.corners) corner *= 1.04;
  const std::vector<std::string> found = contradictions(calibrate_inertial(larger));
  ASSERT_FALSE(found.empty());
  EXPECT_NE(found[0].find("sizes of the target"), std::string::npos) << found[0];
  InertialCalibrationInput in_g = input;
  for (ImuSample& sample : in_g.imu) sample.specific_force_imu /= kStandardGravity;
  EXPECT_NE(fault_of(in_g).find("expected about 9.81"), std::string::npos) << fault_of(in_g);
}

// Read upwards where downwards is stated: the readout is negative until it is turned round.
TEST(InertialCalibration, ASensorThatIsReadTheOtherWayRoundIsTurned) {
  BoardRigScene scene{.cameras = mounted(1, 0.015), .time_offset = 0.01, .seconds = 12};
  scene.cameras[0].shutter.direction = ReadoutDirection::kUp;
  InertialCalibrationInput input = inertial_views(scene, 4);
  input.cameras.cameras[0].shutter.direction = ReadoutDirection::kDown;
  const InertialCalibration found = calibrate_inertial(input);
  EXPECT_EQ(found.cameras[0].shutter.direction, ReadoutDirection::kUp);
  EXPECT_NEAR(found.cameras[0].shutter.readout, 0.015, 2e-4);
  EXPECT_NEAR(found.time_offsets[0], 0.01, 2e-4);
  const int offset = found.layout.offset_row(0), readout = found.layout.readout_row(0);
  EXPECT_EQ(found.values[offset], found.time_offsets[0]);
  EXPECT_EQ(found.values[readout], found.cameras[0].shutter.readout);
  EXPECT_LT(found.covariance(offset, readout), 0) << "an early first line is a long readout";
}

TEST(RotationAlignment, FindsMountingAndOffsetFromNothing) {
  const BoardRigScene scene{.cameras = mounted(1), .seconds = 10};
  const BoardMotion motion(1);
  const InertialCalibrationInput input = inertial_views(scene, 3);
  for (const double offset : {-0.4, 0.0, 0.25}) {
    std::vector<SeenAttitude> attitudes;
    for (double t = 1; t < 10; t += 0.05) {
      const Eigen::Matrix3d cam_R_target =
          scene.cameras[0].cam_T_imu.R * motion.target_T_imu(t).R.transpose();
      attitudes.push_back(
          {Time(std::chrono::nanoseconds(std::llround(1e9 * (t - offset)))), cam_R_target});
    }
    const auto found = align_rotations(attitudes, input.imu);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->time_offset, offset, 0.002);
    EXPECT_LT(so3::log(found->cam_R_imu * scene.cameras[0].cam_T_imu.R.transpose()).norm(), 0.01);
    EXPECT_LT(found->unexplained, 0.01);
  }
}

}  // namespace
}  // namespace chasles::test
