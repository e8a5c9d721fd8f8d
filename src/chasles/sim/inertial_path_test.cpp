#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/sim/inertial_path.hpp>
#include <chasles/sim/inertial_sim.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;

InertialSettings without_sway() {
  InertialSettings settings = inertial_scene("hallway").settings;
  settings.rest_duration = 1;
  settings.start_duration = 1.5;
  settings.bob_amplitude = settings.sway_amplitude = settings.roll_amplitude = 0;
  settings.pitch_amplitude = settings.yaw_amplitude = 0;
  return settings;
}

double heading(const SE3& pose) { return std::atan2(pose.R(1, 0), pose.R(0, 0)); }

std::string complaint(const InertialSettings& settings) {
  try {
    inertial_motion({.name = "", .doc = "", .settings = settings});
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(HallwayPath, FourRightTurnsLeadBackToTheStart) {
  const InertialSettings settings = without_sway();
  const Trajectory path = hallway_path(settings);
  EXPECT_LT(path.front().pose.p.norm(), 1e-12);
  EXPECT_LT((path.back().pose.p - path.front().pose.p).norm(), 1e-7);
  double turned = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double step =
        std::remainder(heading(path[i].pose) - heading(path[i - 1].pose), 2 * std::numbers::pi);
    EXPECT_LT(step, 1e-9);
    turned += step;
  }
  EXPECT_NEAR(turned, -2 * std::numbers::pi, 1e-9);
  EXPECT_GT(to_seconds(path.back().time), 60);
  EXPECT_LT(to_seconds(path.back().time), 80);
}

TEST(HallwayPath, AWalkAtOneSpeedThatStartsFromStandstill) {
  const InertialSettings settings = without_sway();
  const Spline motion = inertial_motion({.name = "", .doc = "", .settings = settings});
  for (double t = 0; t < 0.8; t += 0.1) {
    EXPECT_LT(motion_at(motion, t).v_world.norm(), 1e-6) << t;
  }
  int turning = 0, count = 0;
  for (double t = 2.6; t < motion.duration; t += 0.01, ++count) {
    const Motion now = motion_at(motion, t);
    ASSERT_NEAR(now.v_world.norm(), 1.2, 1e-3) << t;
    // The walker faces the direction of travel, also in turns.
    ASSERT_NEAR((now.world_T_imu.R.transpose() * now.v_world).x(), 1.2, 1e-3) << t;
    turning += now.omega_imu.norm() > 1e-3;
  }
  EXPECT_LE(turning * 0.01, 4 * settings.turn_duration + 0.1);
  EXPECT_GE(turning * 0.01, 4 * settings.turn_duration * 0.8);
}

TEST(HallwayPath, StepsAreSeenInTheAcceleration) {
  const InertialScene scene = inertial_scene("hallway");
  const Spline motion = inertial_motion(scene);
  double highest = 0, worst_tilt = 0;
  for (double t = 5; t < 15; t += 0.001) {
    const Motion now = motion_at(motion, t);
    highest = std::max(highest, now.a_world.z());
    worst_tilt = std::max(worst_tilt, std::acos(now.world_T_imu.R(2, 2)));
  }
  // A sine of 2.5 cm at 2 Hz.
  EXPECT_NEAR(highest, 0.025 * std::pow(4 * std::numbers::pi, 2), 0.1);
  EXPECT_GT(worst_tilt, 0.012);
  EXPECT_LT(worst_tilt, 0.015 + 0.012);
}

TEST(HallwayPath, MovingAtOnceWhereThereIsNoStandstill) {
  InertialSettings settings = without_sway();
  settings.rest_duration = settings.start_duration = 0;
  const Spline motion = inertial_motion({.name = "", .doc = "", .settings = settings});
  EXPECT_TRUE(test::agree(motion_at(motion, 0).v_world, Vector3d(1.2, 0, 0), 1e-5));
}

TEST(HallwayPath, AWalkThroughAWallIsRejected) {
  InertialSettings settings;
  settings.corridor_width = 1;
  settings.turn_duration = 6;
  EXPECT_NE(complaint(settings).find("corridor_width"), std::string::npos);
  settings = {};
  settings.bob_amplitude = 1;
  settings.imu_height = 0.5;
  EXPECT_NE(complaint(settings).find("nearer than 0.1 m to a wall"), std::string::npos);
  settings = {};
  settings.turn_duration = 100;
  EXPECT_NE(complaint(settings).find("turn_duration"), std::string::npos);
}

TEST(TurntablePath, TwiceAroundTheCubeLookingAtIt) {
  const InertialScene scene = inertial_scene("turntable");
  const Spline motion = inertial_motion(scene);
  double angle = 0;
  Vector3d last = motion_at(motion, 0).world_T_imu.p;
  double nearest = 1e9, farthest = 0;
  for (double t = 0; t <= motion.duration; t += 0.01) {
    const SE3 pose = motion_at(motion, t).world_T_imu;
    angle += std::remainder(std::atan2(pose.p.y(), pose.p.x()) - std::atan2(last.y(), last.x()),
                            2 * std::numbers::pi);
    last = pose.p;
    nearest = std::min(nearest, pose.p.norm());
    farthest = std::max(farthest, pose.p.norm());
    const Vector3d centre = (pose.R.transpose() * -pose.p).normalized();
    EXPECT_GT(centre.x(), std::cos(0.05)) << t;
  }
  EXPECT_NEAR(angle, 4 * std::numbers::pi, 0.01);
  EXPECT_NEAR(motion.duration, 35, 1e-9);
  EXPECT_NEAR(nearest, 7.4, 0.05);
  EXPECT_NEAR(farthest, 8.6, 0.05);
}

TEST(TrajectoryPath, NeedsATrajectory) {
  EXPECT_THROW(inertial_motion(inertial_scene("trajectory")), UsageError);
}

TEST(Paths, TooManyKnotsAreRejected) {
  InertialSettings settings;
  settings.sections = 1000;
  settings.hall_length = settings.hall_width = 1e4;
  EXPECT_NE(complaint(settings).find("knot_interval"), std::string::npos);
}

}  // namespace
}  // namespace chasles
