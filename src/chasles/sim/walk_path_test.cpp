#include <cmath>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/walk_path.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;

InertialSettings walk_settings() { return inertial_scene("walk").settings; }

std::string walk_complaint(const InertialSettings& settings) {
  try {
    walk_path(settings);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

double way_length(const Trajectory& path) {
  double length = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    length += (path[i].pose.p - path[i - 1].pose.p).head<2>().norm();
  }
  return length;
}

TEST(WalkPath, GoesRoundBothLoopsAndComesBackToItsStart) {
  InertialSettings s = walk_settings();
  s.sway_amplitude = 0;
  const Trajectory path = walk_path(s);
  // A turn cuts its corner: 1.3 m/s * 1.6 s, instead of twice its reach.
  EXPECT_NEAR(way_length(path), 2 * (4 * 24 + 4 * 16), 12);
  EXPECT_GT(way_length(path), 300);
  Vector3d low = Vector3d::Zero(), high = low;
  for (const auto& [time, pose] : path) {
    low = low.cwiseMin(pose.p);
    high = high.cwiseMax(pose.p);
  }
  EXPECT_NEAR(high.y(), 24, 1e-6);
  EXPECT_NEAR(low.y(), -24, 1e-6);
  EXPECT_NEAR(high.x() - low.x(), 16, 1e-6);
  EXPECT_LT((path.back().pose.p - path.front().pose.p).head<2>().norm(), 1e-6);
}

TEST(WalkPath, StandsAndThenBobsWithEveryStep) {
  const InertialSettings s = walk_settings();
  const Spline motion = inertial_motion(inertial_scene("walk"));
  for (double t = 0.2; t < s.rest_duration - 0.2; t += 0.1) {
    EXPECT_LT(motion_at(motion, t).v_world.norm(), 1e-6) << t;
  }
  int rising = 0;
  double last = 0;
  const double begin = 10, seconds = 60;
  for (double t = begin; t < begin + seconds; t += 0.01) {
    const double height = motion_at(motion, t).world_T_imu.p.z();
    EXPECT_LT(std::abs(height), 1.05 * s.bob_amplitude);
    rising += last < 0 && height >= 0 ? 1 : 0;
    last = height;
  }
  EXPECT_NEAR(rising / seconds, 1.8, 0.05);
}

TEST(WalkPath, ItsDurationCanBeShortened) {
  InertialSettings s = walk_settings();
  const Trajectory whole = walk_path(s);
  s.walk_duration = 30;
  const Trajectory started = walk_path(s);
  EXPECT_NEAR(to_seconds(started.back().time), 30, 1e-6);
  // The same path, only shorter.
  for (std::size_t i = 0; i < started.size(); i += 100) {
    const double at = to_seconds(started[i].time) / to_seconds(whole.back().time);
    const auto k =
        static_cast<std::size_t>(std::lround(at * static_cast<double>(whole.size() - 1)));
    EXPECT_LT((started[i].pose.p - whole[k].pose.p).norm(), 0.02);
  }
  s.walk_duration = 1e5;
  EXPECT_EQ(walk_path(s).size(), whole.size());
}

TEST(WalkPath, KeepsAwayFromWallsAndFurniture) {
  const InertialSettings s = walk_settings();
  const auto walls = plan_walls(walk_plan(s));
  EXPECT_GT(walls.size(), 100U);
  double nearest = 10;
  for (const auto& [time, pose] : walk_path(s)) {
    nearest = std::min(nearest, distance_to_walls(walls, pose.p.head<2>()));
    for (const Box& box : walk_furniture(s)) {
      nearest = std::min(nearest, (pose.p - pose.p.cwiseMax(box.low).cwiseMin(box.high)).norm());
    }
  }
  EXPECT_GT(nearest, 0.6);
  EXPECT_LT(nearest, 1.4);
}

TEST(WalkPath, RejectsABuildingThatIsTooSmall) {
  InertialSettings s = walk_settings();
  s.hall_width = 8;
  EXPECT_NE(walk_complaint(s).find("hall_width = 8 m: expected at least 8.6 m"), std::string::npos)
      << walk_complaint(s);
  s.hall_width = 1e4;
  EXPECT_NE(walk_complaint(s).find("at most 200 m"), std::string::npos) << walk_complaint(s);
  s = walk_settings();
  s.corridor_width = 0.6;
  EXPECT_NE(walk_complaint(s).find("corridor_width = 0.6 m: the walk comes nearer than"),
            std::string::npos)
      << walk_complaint(s);
  s = walk_settings();
  s.walk_duration = 5;
  EXPECT_NE(walk_complaint(s).find("walk_duration = 5 s: expected more than the 5 s"),
            std::string::npos)
      << walk_complaint(s);
}

TEST(WalkPath, TheDrawnPlanHasItsWallsAndTheFurnitureOnTheFloor) {
  InertialScene scene = inertial_scene("walk");
  scene.settings.walk_duration = 6;
  const Plan plan = simulate_inertial(scene).plan;
  double walls = 0, drawn = 0;
  for (const WallSegment& wall : plan_walls(walk_plan(scene.settings))) {
    walls += (wall.b - wall.a).norm();
  }
  std::size_t standing = 0, outlines = 0;
  for (const Box& box : walk_furniture(scene.settings)) {
    if (box.low.z() == -scene.settings.imu_height) ++standing;
  }
  for (const PlanLine& line : plan) {
    EXPECT_EQ(line.points.front(), line.points.back());
    if (line.kind == PlanLine::Kind::kFurniture) {
      ++outlines;
      continue;
    }
    for (std::size_t i = 1; i < line.points.size(); ++i) {
      drawn += (line.points[i] - line.points[i - 1]).norm();
    }
  }
  EXPECT_NEAR(drawn, walls, 1e-9 * walls);
  EXPECT_EQ(outlines, standing);
  EXPECT_LT(standing, walk_furniture(scene.settings).size()) << "the scene has lintels too";
}

TEST(WalkPath, ItsLandmarksAreSeenOnTheWay) {
  InertialScene scene = inertial_scene("walk");
  scene.settings.walk_duration = 20;
  const Recording recording = simulate_inertial(scene);
  EXPECT_EQ(recording.frames.size(), 401U);
  double seen = 0;
  for (const FeatureFrame& frame : recording.frames)
    seen += static_cast<double>(frame.pixels.size());
  EXPECT_GT(seen / 401, 25);
}

}  // namespace
}  // namespace chasles
