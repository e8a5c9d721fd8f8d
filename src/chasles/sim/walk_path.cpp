#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/sim/inertial_path_detail.hpp>
#include <chasles/sim/smoothstep.hpp>
#include <chasles/sim/walk_path.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;

constexpr double kWalkClearance = 0.25;  // [m], of the IMU from walls and furniture

double walk_straight(const InertialSettings& s, int section) {
  return (section % 2 == 0 ? s.hall_width : s.hall_length) - 2 * turn_reach(s);
}

// Four turns to the left, +1, around one loop, then four to the right, -1, around the other.
int turn_side(int section) { return section % 8 < 4 ? 1 : -1; }

Step walked_loops(const InertialSettings& s, double way) {
  const double turn = turn_length(s), reach = turn_reach(s);
  Step at{Vector2d::Zero(), 0};
  for (int section = 0;; ++section) {
    const double straight = walk_straight(s, section);
    const Eigen::Rotation2Dd heading(at.heading);
    at.p += heading * Vector2d(std::min(way, straight), 0);
    if (way <= straight) return at;
    way -= straight;
    const double side = turn_side(section);
    if (way <= turn) {
      const Vector2d right = turn * quarter_turn(way / turn);
      at.p += heading * Vector2d(right.x(), -side * right.y());
      at.heading += side * std::numbers::pi / 2 * smoothstep(way / turn);
      return at;
    }
    at.p += heading * Vector2d(reach, side * reach);
    at.heading += side * std::numbers::pi / 2;
    way -= turn;
  }
}

// Time on the path [s]: all sections, or the limit of the recording.
double way_duration(const InertialSettings& s) {
  double length = s.sections * turn_length(s);
  for (int i = 0; i < s.sections; ++i) length += walk_straight(s, i);
  const double all = length / s.walking_speed;
  if (s.walk_duration == 0) return all;
  const double before = s.rest_duration + s.start_duration / 2;
  if (s.walk_duration <= before) {
    throw UsageError(fmt::format(
        "simulation setting walk_duration = {} s: expected more than the {} s that rest_duration "
        "and half of start_duration take, or 0",
        s.walk_duration, before));
  }
  return std::min(all, s.walk_duration - before);
}

bool touches(const Box& box, const Eigen::Vector3d& p) {
  return (p.array() > box.low.array() - kWalkClearance).all() &&
         (p.array() < box.high.array() + kWalkClearance).all();
}

void check_walk_clearance(const InertialSettings& s, const Trajectory& path) {
  const auto walls = plan_walls(walk_plan(s));
  const auto furniture = walk_furniture(s);
  const double ceiling = s.corridor_height - s.imu_height - kWalkClearance;
  // The path repeats itself: on a very long path not every pose needs a check.
  constexpr std::size_t kSampled = 100000;
  for (std::size_t i = 0; i < path.size(); i += 1 + path.size() / kSampled) {
    const Eigen::Vector3d& p = path[i].pose.p;
    const bool free = distance_to_walls(walls, p.head<2>()) > kWalkClearance && p.z() < ceiling &&
                      p.z() > kWalkClearance - s.imu_height;
    if (free && std::ranges::none_of(furniture, [&](const Box& b) { return touches(b, p); })) {
      continue;
    }
    throw UsageError(fmt::format(
        "simulation setting corridor_width = {} m: the walk comes nearer than {} m to a wall or a "
        "piece of furniture at {:.1f} s; expected a wider or higher corridor, less sway, or a "
        "shorter turn_duration",
        s.corridor_width, kWalkClearance, to_seconds(path[i].time)));
  }
}

}  // namespace

Trajectory walk_path(const InertialSettings& settings) {
  walk_plan(settings);
  Trajectory path = sample_way(settings, way_duration(settings), [&](double time) {
    return with_gait(settings, walked_loops(settings, settings.walking_speed * time), time);
  });
  check_walk_clearance(settings, path);
  return path;
}

}  // namespace chasles
