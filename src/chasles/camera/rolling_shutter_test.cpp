#include <chasles/camera/camera_testing.hpp>
#include <chasles/camera/rolling_shutter.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Camera rolling(ReadoutDirection direction) {
  Camera camera = test::euroc_camera();  // 752 x 480
  camera.shutter = {.readout = 0.024, .direction = direction};
  camera.cam_T_imu = {so3::exp({0.3, -1.2, 0.4}), {0.1, -0.05, 0.02}};
  return camera;
}

TEST(RollingShutter, ReadsTheFirstLineAtTheTimeOfTheImage) {
  EXPECT_EQ(line_delay(rolling(ReadoutDirection::kDown), {300, 0}), 0);
  EXPECT_NEAR(line_delay(rolling(ReadoutDirection::kUp), {300, 479}), 0, 1e-17);
  EXPECT_EQ(line_delay(rolling(ReadoutDirection::kRight), {0, 200}), 0);
  EXPECT_NEAR(line_delay(rolling(ReadoutDirection::kLeft), {751, 200}), 0, 1e-17);
}

TEST(RollingShutter, ReadsTheOtherLinesOneAfterTheOther) {
  constexpr double kRow = 0.024 / 480, kColumn = 0.024 / 752;
  EXPECT_NEAR(line_delay(rolling(ReadoutDirection::kDown), {300, 120}), 120 * kRow, 1e-15);
  EXPECT_NEAR(line_delay(rolling(ReadoutDirection::kUp), {300, 120}), 359 * kRow, 1e-15);
  EXPECT_NEAR(line_delay(rolling(ReadoutDirection::kRight), {300, 120}), 300 * kColumn, 1e-15);
  EXPECT_NEAR(line_delay(rolling(ReadoutDirection::kLeft), {300, 120}), 451 * kColumn, 1e-15);
}

TEST(RollingShutter, AMotionTurnsAndMovesByItsPolynomials) {
  const ReadoutMotion motion{.rate = {0.4, -0.2, 1.1},
                             .rate_change = {3, 5, -2},
                             .velocity = {1, 2, -0.5},
                             .acceleration = {-4, 0.3, 2}};
  const SE3 moved = motion.after(0.02);
  const Vector3d phi = 0.02 * motion.rate + 0.0004 * motion.rate_change;
  EXPECT_TRUE(test::agree(moved.R, so3::exp(phi), 1e-15));
  EXPECT_TRUE(test::agree(moved.p, 0.02 * motion.velocity + 0.0004 * motion.acceleration, 1e-15));
  EXPECT_TRUE(test::agree(motion.after(0).R, Eigen::Matrix3d::Identity(), 1e-15));
}

// The camera at the line sees a fixed point as from the IMU that has moved on.
TEST(RollingShutter, ACameraAtALineIsWhereTheImuHasMoved) {
  const Camera camera = rolling(ReadoutDirection::kDown);
  const ReadoutMotion motion{.rate = {0.4, -0.2, 1.1}, .velocity = {1, 2, -0.5}};
  const Vector2d pixel(100, 240);
  const SE3 imu_T_later = motion.after(0.012);
  const Vector3d p_imu(3, 1, -2), p_later = imu_T_later.inverse() * p_imu;
  EXPECT_TRUE(test::agree(at_line(camera, motion, pixel).cam_T_imu * p_imu,
                          camera.cam_T_imu * p_later, 1e-14));
  EXPECT_TRUE(test::agree(imu_T_line(camera, motion, pixel).p, imu_T_later.p, 1e-15));
}

TEST(RollingShutter, AGlobalShutterHasNoLines) {
  Camera camera = rolling(ReadoutDirection::kDown);
  camera.shutter = {};
  const ReadoutMotion motion{.rate = {0.4, -0.2, 1.1}, .velocity = {1, 2, -0.5}};
  EXPECT_EQ(at_line(camera, motion, {100, 240}).cam_T_imu.R, camera.cam_T_imu.R);
  EXPECT_EQ(at_line(camera, motion, {100, 240}).cam_T_imu.p, camera.cam_T_imu.p);
  EXPECT_EQ(imu_T_line(camera, motion, {100, 240}).p, Vector3d::Zero());
}

}  // namespace
}  // namespace chasles
