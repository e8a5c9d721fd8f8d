#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <chasles/initialise/inertial_start.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A camera that looks along the IMU's x axis, with the image's top up, rotated by `tilt` about the
/// IMU's y axis (positive: down), and by `roll` about its line of sight.
Camera camera_tilted(double tilt, double roll = 0) {
  Matrix3d imu_R_straight;  // its columns: the camera's right, down and forward
  imu_R_straight << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Camera camera;
  camera.cam_T_imu =
      SE3{so3::exp({0, tilt, 0}) * so3::exp({roll, 0, 0}) * imu_R_straight, {0.1, 0, 0}}.inverse();
  return camera;
}

Matrix3d heading_of(double angle) { return so3::exp({0, 0, angle}); }

TEST(CameraHeading, IsThatOfTheLineOfSight) {
  for (const double tilt : {-0.78, 0.0, 0.5, 0.78}) {
    for (const double roll : {0.0, 0.5, std::numbers::pi / 2, 3.0}) {
      EXPECT_NEAR(camera_heading(heading_of(2.5), camera_tilted(tilt, roll)), 2.5, 1e-12)
          << tilt << " " << roll;
    }
  }
}

// Down, and up: there the bottom of the image is ahead.
TEST(CameraHeading, OfASteepCameraIsThatOfAnEdgeOfItsImage) {
  for (const double tilt : {0.8, std::numbers::pi / 2, 2.2, -0.8, -1.2}) {
    EXPECT_NEAR(camera_heading(heading_of(-1.2), camera_tilted(tilt)), -1.2, 1e-12) << tilt;
  }
}

InertialStart some_start() {
  InertialStart start{.time = from_seconds(3),
                      .nav_T_imu = {heading_of(0.4) * so3::exp({0.05, -0.1, 0}), Vector3d::Zero()},
                      .v_nav = {1.2, -0.5, 0.1}};
  Matrix15d P = Matrix15d::Zero();
  P.topLeftCorner<2, 2>() << 4e-6, 1e-6, 1e-6, 9e-6;
  P.block<3, 3>(6, 6).diagonal() << 1e-3, 4e-3, 2e-3;
  P.bottomRightCorner<6, 6>().diagonal().setConstant(1e-4);
  P(0, 10) = P(10, 0) = 1e-5;
  start.covariance = P;
  return start;
}

TEST(PlacedStart, HasThePositionAndTheHeadingOfTheSettings) {
  const Camera camera = camera_tilted(0.2);
  InitialiserSettings settings;
  settings.position_x = 12;
  settings.position_y = -3;
  settings.position_z = 1.5;
  settings.heading = 2;
  const InertialStart before = some_start(), after = placed(before, settings, camera);
  EXPECT_EQ(after.nav_T_imu.p, Vector3d(12, -3, 1.5));
  EXPECT_NEAR(camera_heading(after.nav_T_imu.R, camera), 2, 1e-12);
  const Matrix3d turn = after.nav_T_imu.R * before.nav_T_imu.R.transpose();
  EXPECT_TRUE(test::agree(turn.col(2), Vector3d(0, 0, 1), 1e-12)) << "the tilt stays";
  EXPECT_TRUE(test::agree(after.v_nav, turn * before.v_nav, 1e-12));
  EXPECT_TRUE(test::agree(after.covariance->block<3, 3>(0, 9),
                          turn * before.covariance->block<3, 3>(0, 9), 1e-15));
  EXPECT_EQ(after.covariance->row(2).norm(), 0) << "the heading defines nav";
}

TEST(PlacedStart, WithoutSettingsStaysAsItIs) {
  const InertialStart before = some_start(), after = placed(before, {}, camera_tilted(0));
  ASSERT_TRUE(after.covariance);
  EXPECT_EQ(after.nav_T_imu.R, before.nav_T_imu.R);
  EXPECT_EQ(after.nav_T_imu.p, before.nav_T_imu.p);
  EXPECT_EQ(*after.covariance, *before.covariance);
}

TEST(PlacedStart, AnErrorOfTheHeadingTurnsTheVelocity) {
  InitialiserSettings settings;
  settings.heading = 1;
  const InertialStart sure = placed(some_start(), settings, camera_tilted(0));
  settings.heading_sigma = 0.05;
  const InertialStart unsure = placed(some_start(), settings, camera_tilted(0));
  // Of a small angle, numerically.
  const double angle = 1e-6;
  Eigen::Matrix<double, 15, 1> by_angle = Eigen::Matrix<double, 15, 1>::Zero();
  const InertialStart other = turned(sure, angle);
  by_angle.head<3>() = so3::log(other.nav_T_imu.R * sure.nav_T_imu.R.transpose()) / angle;
  by_angle.segment<3>(6) = (other.v_nav - sure.v_nav) / angle;
  EXPECT_TRUE(test::agree(*unsure.covariance - *sure.covariance,
                          0.05 * 0.05 * by_angle * by_angle.transpose(), 1e-8));
}

/// The short hallway, from a standstill, with these settings of the start.
test::Estimates walk_from(const InitialiserSettings& start, bool nav_attitude) {
  InertialScene scene = test::short_hallway();
  scene.settings.rest_duration = 2;
  scene.settings.start_duration = 1;
  const Recording recording = simulate_inertial(scene);
  InertialSensors sensors{.cameras = recording.cameras,
                          .noise = *recording.imu_noise,
                          .imu = {.convention = recording.imu_convention},
                          .pixel_sigma = *recording.single_pixel_sigma};
  InertialSlamSettings filter;
  filter.nav_attitude = nav_attitude;
  // It measures the velocity in nav's axes, and so a little of an uncertain heading.
  filter.zupt_velocity_sigma = 0;
  InertialSession session(filter, start, std::move(sensors));
  return test::play(session, recording);
}

/// Variance of the position across the way from the start [m^2].
double variance_aside(const test::Estimates& estimates) {
  const Vector3d way = estimates.back().world_T_imu.p - estimates.front().world_T_imu.p;
  const Vector3d aside = Vector3d::UnitZ().cross(way).normalized();
  return aside.dot(estimates.back().covariance.block<3, 3>(3, 3) * aside);
}

/// With the world's attitude known or in the state.
class WalkOnThePlan : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(NavAttitude, WalkOnThePlan, ::testing::Bool());

// The heading is not observable: the whole walk turns with it, and its error stays.
TEST_P(WalkOnThePlan, BeginsThereAndKeepsTheErrorOfItsHeading) {
  constexpr double kSigma = 0.05;
  InitialiserSettings settings;
  const test::Estimates plain = walk_from(settings, GetParam());
  settings.heading = 2;
  settings.position_x = 12;
  settings.position_y = -3;
  const test::Estimates moved = walk_from(settings, GetParam());
  settings.heading_sigma = kSigma;
  const test::Estimates unsure = walk_from(settings, GetParam());
  ASSERT_GT(plain.size(), 200U);
  ASSERT_EQ(moved.size(), plain.size());
  ASSERT_EQ(unsure.size(), plain.size());
  const SE3 nav_T_plain = moved.front().world_T_imu * plain.front().world_T_imu.inverse();
  EXPECT_TRUE(test::agree(nav_T_plain.R.col(2), Vector3d(0, 0, 1), 1e-9));
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const SE3 expected = nav_T_plain * plain[i].world_T_imu;
    EXPECT_LT((moved[i].world_T_imu.p - expected.p).norm(), 1e-6) << i;
    EXPECT_LT((unsure[i].world_T_imu.p - expected.p).norm(), 1e-6) << i;
  }
  EXPECT_TRUE(test::agree(moved.front().world_T_imu.p, Vector3d(12, -3, 0), 0.01));
  EXPECT_NEAR(std::sqrt(unsure.front().covariance(2, 2)), kSigma, 1e-4);
  const double of_heading = unsure.back().covariance(2, 2) - moved.back().covariance(2, 2);
  EXPECT_NEAR(of_heading / (kSigma * kSigma), 1, 0.02);
  // Far from the start it is an error of the position.
  const double way = (moved.back().world_T_imu.p - moved.front().world_T_imu.p).norm();
  const double of_position = variance_aside(unsure) - variance_aside(moved);
  EXPECT_NEAR(std::sqrt(of_position), kSigma * way, 0.05 * kSigma * way);
}

}  // namespace
}  // namespace chasles
