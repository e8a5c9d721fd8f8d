#include <cmath>

#include <gtest/gtest.h>

#include <chasles/lie/testing.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/inertial_world.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;

// A camera at the IMU, pointing along x from the origin.
InertialSettings at_origin() {
  InertialSettings settings;
  settings.min_range = 0.8;
  settings.camera_x = settings.camera_y = settings.camera_z = 0;
  return settings;
}

const InertialWorld kEmpty{};

TEST(InertialWorld, AWallHidesWhatIsBehindItButNotItsOwnFace) {
  const std::vector<Box> walls{{{10, -10, -1}, {30, 10, 4}}};
  EXPECT_FALSE(blocked(walls, Vector3d::Zero(), {10, 3, 2}));
  EXPECT_FALSE(blocked(walls, Vector3d::Zero(), {9, 0, -1}));
  EXPECT_TRUE(blocked(walls, Vector3d::Zero(), {30, 3, 2}));
  EXPECT_TRUE(blocked(walls, Vector3d::Zero(), {40, 0, 0}));
  EXPECT_FALSE(blocked(walls, {0, 12, 0}, {40, 12, 0}));
  EXPECT_FALSE(blocked(walls, Vector3d::Zero(), {-40, 0, 0}));
  EXPECT_FALSE(blocked(walls, {0, 0, 5}, {40, 0, 5}));    // over it
  EXPECT_FALSE(blocked(walls, {10, -3, 0}, {10, 5, 0}));  // along its face
  EXPECT_FALSE(blocked({}, Vector3d::Zero(), {40, 0, 0}));
}

TEST(InertialWorld, TheCameraLooksAlongXWithItsImageUpright) {
  const InertialSettings settings = at_origin();
  const Camera camera = make_cameras(settings).at(0);
  const auto see = [&](const Vector3d& p) {
    return visible_pixel(settings, kEmpty, camera, {}, p).value();
  };
  // Pinhole by hand: left is less u, up is less v.
  EXPECT_TRUE(test::agree(see({4, 0, 0}), Eigen::Vector2d(349.5, 270), 1e-12));
  EXPECT_TRUE(test::agree(see({4, 1, 0}), Eigen::Vector2d(349.5 - 120, 270), 1e-12));
  EXPECT_TRUE(test::agree(see({4, 0, 1}), Eigen::Vector2d(349.5, 270 - 120), 1e-12));
}

TEST(InertialWorld, CamerasStandWhereTheSettingsSay) {
  InertialSettings settings;
  settings.cameras = 2;
  settings.camera_tilt_y = 0.2;
  const auto cameras = make_cameras(settings);
  ASSERT_EQ(cameras.size(), 2U);
  const SE3 first = cameras[0].cam_T_imu.inverse(), second = cameras[1].cam_T_imu.inverse();
  EXPECT_TRUE(test::agree(first.p, Vector3d(0.05, 0.02, 0.03), 1e-15));
  EXPECT_TRUE(test::agree(second.p, Vector3d(0.05, 0.02 - 0.2, 0.03), 1e-15));
  // A positive rotation about the left axis tilts the camera down.
  EXPECT_TRUE(
      test::agree(first.R * Vector3d::UnitZ(), Vector3d(std::cos(0.2), 0, -std::sin(0.2)), 1e-15));
  EXPECT_TRUE(test::agree(first.R, second.R, 1e-15));
}

TEST(InertialWorld, ARigLooksWhereItsLayoutSays) {
  InertialSettings settings;
  settings.cameras = 4;
  settings.camera_tilt_y = 0.1;
  const auto axis = [&](int camera) {
    const SE3 imu_T_cam =
        make_cameras(settings)[static_cast<std::size_t>(camera)].cam_T_imu.inverse();
    return Eigen::Vector3d(imu_T_cam.R.col(2));
  };
  const auto place = [&](int camera) {
    return make_cameras(settings)[static_cast<std::size_t>(camera)].cam_T_imu.inverse().p;
  };
  const Eigen::Vector3d ahead(std::cos(0.1), 0, -std::sin(0.1));
  const Eigen::Vector3d first(settings.camera_x, settings.camera_y, settings.camera_z);
  for (int i = 0; i < 4; ++i) EXPECT_LT((axis(i) - ahead).norm(), 1e-12);
  EXPECT_LT((place(3) - first - Eigen::Vector3d(0, -3 * settings.baseline, 0)).norm(), 1e-12);
  settings.rig = RigLayout::kRing;
  const Eigen::Vector3d left(0, std::cos(0.1), -std::sin(0.1));
  EXPECT_LT((axis(1) - left).norm(), 1e-12);
  EXPECT_LT((place(1) - Eigen::Vector3d(-first.y(), first.x(), first.z())).norm(), 1e-12);
  EXPECT_LT(axis(2).x(), -0.99);
  settings.rig = RigLayout::kBackToBack;
  EXPECT_LT((axis(2) - ahead).norm(), 1e-12);
  EXPECT_LT((axis(3) - axis(1)).norm(), 1e-12);
  EXPECT_LT(axis(1).x(), -0.99);
  EXPECT_NEAR((place(3) - place(1)).norm(), settings.baseline, 1e-12);
  EXPECT_NEAR((place(2) - place(0)).norm(), settings.baseline, 1e-12);
}

TEST(InertialWorld, WhatIsNotVisible) {
  const InertialSettings settings = at_origin();
  const Camera camera = make_cameras(settings).at(0);
  const InertialWorld wall{.points = {}, .walls = {{{5, -1, -1}, {6, 1, 1}}}};
  const auto seen = [&](const Vector3d& p, const InertialWorld& world = kEmpty) {
    return visible_pixel(settings, world, camera, {}, p).has_value();
  };
  EXPECT_TRUE(seen({14.9, 0, 0}));
  EXPECT_FALSE(seen({15.1, 0, 0}));  // too far
  EXPECT_TRUE(seen({0.81, 0, 0}));
  EXPECT_FALSE(seen({0.79, 0, 0}));   // too near
  EXPECT_FALSE(seen({-5, 0.1, 0}));   // behind
  EXPECT_TRUE(seen({4.8, 3.44, 0}));  // u = 349.5 - 344
  EXPECT_FALSE(seen({4.8, 3.46, 0}));
  EXPECT_TRUE(seen({4.8, 0, -2.63}));  // v = 270 + 263, of 540
  EXPECT_FALSE(seen({4.8, 0, -2.66}));
  EXPECT_FALSE(seen({7, 0.5, 0.5}, wall));
  EXPECT_TRUE(seen({5, 0.5, 0.5}, wall));
  EXPECT_TRUE(seen({7, 2.5, 0.5}, wall));
  InertialSettings transparent = settings;
  transparent.occlusion = false;
  EXPECT_TRUE(visible_pixel(transparent, wall, camera, {}, {7, 0.5, 0.5}));
}

TEST(InertialWorld, TheHallwaysLandmarksLieOnItsSurfaces) {
  const InertialSettings settings;
  const Hallway hall = make_hallway(settings);
  const InertialWorld world = make_world(settings, {}, {});
  double floor = 0, outer = 0, inner = 0;
  for (const Vector3d& p : world.points) {
    const auto on = [&](const Box& box, int axis) {
      return std::min(std::abs(p[axis] - box.low[axis]), std::abs(p[axis] - box.high[axis])) < 1e-9;
    };
    const bool level = on(hall.outer, 2);
    EXPECT_FALSE(blocked(world.walls, p + 1e-6 * (Vector3d(14, -6, 0) - p), p) && level);
    if (level)
      ++floor;
    else if (on(hall.outer, 0) || on(hall.outer, 1))
      ++outer;
    else if (on(hall.inner, 0) || on(hall.inner, 1))
      ++inner;
    else
      ADD_FAILURE() << p.transpose();
  }
  // Areas: floor and ceiling of the ring, 2.8 m high walls.
  const double expected = 4;
  EXPECT_NEAR(floor, expected * 2 * (33 * 15 - 27 * 9), 4 * std::sqrt(expected * 504));
  EXPECT_NEAR(outer, expected * 2.8 * 2 * (33 + 15), 4 * std::sqrt(expected * 269));
  EXPECT_NEAR(inner, expected * 2.8 * 2 * (27 + 9), 4 * std::sqrt(expected * 202));
}

TEST(InertialWorld, TheTurntablesLandmarksLieOnTheCube) {
  const InertialSettings settings = inertial_scene("turntable").settings;
  const InertialWorld world = make_world(settings, {}, {});
  ASSERT_EQ(world.points.size(), 40U);
  for (const Vector3d& p : world.points)
    EXPECT_NEAR(p.cwiseAbs().maxCoeff(), settings.cube_edge / 2, 1e-12);
}

TEST(InertialWorld, ATrajectoryHasEnoughVisibleLandmarksAllAlong) {
  InertialScene scene = inertial_scene("trajectory");
  for (int i = 0; i <= 3000; ++i) {
    const double t = 0.01 * i;
    scene.path.push_back(
        {from_seconds(t), {so3::exp({0, 0, 0.3 * t}), {5 * std::sin(0.3 * t), t, std::cos(t)}}});
  }
  const Spline motion = inertial_motion(scene);
  const auto cameras = make_cameras(scene.settings);
  const InertialWorld world = make_world(scene.settings, motion, cameras);
  for (double t = 0; t < motion.duration; t += 0.1) {
    int seen = 0;
    for (const Vector3d& p : world.points) {
      const SE3 pose = motion_at(motion, t).world_T_imu;
      seen += visible_pixel(scene.settings, world, cameras[0], pose, p).has_value();
    }
    EXPECT_GE(seen, 50) << t;
  }
}

TEST(InertialWorld, LandmarksDependOnTheSeed) {
  InertialSettings settings;
  const auto points = make_world(settings, {}, {}).points;
  EXPECT_EQ(points, make_world(settings, {}, {}).points);
  settings.seed = 2;
  EXPECT_NE(points[0], make_world(settings, {}, {}).points[0]);
}

}  // namespace
}  // namespace chasles
