#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/sim/inertial_path_detail.hpp>
#include <chasles/sim/walk_path.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;

constexpr double kSpareRoom = 6;     // [m], that a block needs besides its corridors
constexpr double kLongest = 200;     // [m]
constexpr double kHallWider = 2;     // [m], on each side of the passage
constexpr double kNichePitch = 4.2;  // [m]
constexpr double kDoorHeight = 2.1;  // [m]

// A straight wall in view of the corridor: its start, its direction, and the space behind it.
struct WallLine {
  Vector2d begin, along, out;
  double length;

  PlanRectangle behind(double from, double to, double near, double far) const {
    const Vector2d a = begin + from * along + near * out, b = begin + to * along + far * out;
    return {a.cwiseMin(b), a.cwiseMax(b)};
  }
};

struct Building {
  FloorPlan plan;
  std::vector<Box> furniture;
  double floor, ceiling;
};

void put(Building& building, const PlanRectangle& r, double height) {
  const double top = std::min(building.floor + height, building.ceiling);
  building.furniture.push_back(
      {{r.low.x(), r.low.y(), building.floor}, {r.high.x(), r.high.y(), top}});
}

void add_office(Building& building, const WallLine& wall, double at) {
  constexpr double kDoor = 0.5, kHalf = 1.6, kThick = 0.15, kDepth = 3.15;
  const PlanRectangle doorway = wall.behind(at - kDoor, at + kDoor, 0, kThick);
  building.plan.rooms.push_back(doorway);
  building.plan.rooms.push_back(wall.behind(at - kHalf, at + kHalf, kThick, kDepth));
  put(building, wall.behind(at - 0.7, at + 0.8, kDepth - 0.7, kDepth), 0.75);
  put(building, wall.behind(at - kHalf, at - kHalf + 0.4, 1, 2.1), 1.7);
  put(building, wall.behind(at + 1.1, at + kHalf, kDepth - 0.5, kDepth), 1.2);
  if (building.floor + kDoorHeight >= building.ceiling) return;
  building.furniture.push_back({{doorway.low.x(), doorway.low.y(), building.floor + kDoorHeight},
                                {doorway.high.x(), doorway.high.y(), building.ceiling}});
}

void add_alcove(Building& building, const WallLine& wall, double at) {
  building.plan.rooms.push_back(wall.behind(at - 0.9, at + 0.9, 0, 0.9));
  put(building, wall.behind(at - 0.6, at + 0.3, 0.45, 0.9), 0.5);
}

// Offices, alcoves and cupboards, alternating.
void furnish(Building& building, const WallLine& wall, int first) {
  int kind = first;
  for (double at = kNichePitch / 2; at + kNichePitch / 2 <= wall.length; at += kNichePitch) {
    if (kind % 3 == 0) add_office(building, wall, at);
    if (kind % 3 == 1) add_alcove(building, wall, at);
    if (kind % 3 == 2) {
      put(building, wall.behind(at - 0.5, at + 0.3, -0.35, 0), kind % 2 == 0 ? 1.9 : 1);
    }
    ++kind;
  }
}

void add_hall(Building& building, const Vector2d& low, const Vector2d& high) {
  building.plan.rooms.push_back({low, high});
  const Vector2d middle = (low + high) / 2, half = (high - low) / 2;
  for (const double x : {-0.6, 0.6}) {
    for (const double y : {-1.0, 1.0}) {
      const Vector2d p = middle + Vector2d(x * half.x(), y * (half.y() - kHallWider / 2));
      put(building, {p.array() - 0.2, p.array() + 0.2}, 1e3);
      const Vector2d q = middle + Vector2d((x - 0.25) * half.x(), y * (half.y() - 0.5));
      put(building, {q - Vector2d(0.7, 0.35), q + Vector2d(0.7, 0.35)}, y > 0 ? 0.75 : 1.1);
    }
  }
}

void check(const InertialSettings& s) {
  const double least = s.corridor_width + kSpareRoom;
  for (const auto& [name, value] :
       {std::pair{"hall_length", s.hall_length}, std::pair{"hall_width", s.hall_width}}) {
    if (value >= least && value >= 2 * turn_reach(s) && value <= kLongest) continue;
    throw UsageError(fmt::format(
        "simulation setting {} = {} m: expected at least {} m for the rooms of the scene walk and "
        "{:.2f} m for two turns, and at most {} m",
        name, value, least, 2 * turn_reach(s), kLongest));
  }
}

Building make_building(const InertialSettings& s) {
  check(s);
  const double half = s.corridor_width / 2, length = s.hall_length, width = s.hall_width;
  const double x0 = -turn_reach(s), x1 = x0 + width;
  const Vector2d h(half, half);
  Building building{{}, {}, -s.imu_height, s.corridor_height - s.imu_height};
  for (const double y : {-length, 0.0, length}) {
    building.plan.rooms.push_back({Vector2d(x0, y) - h, Vector2d(x1, y) + h});
  }
  for (const double x : {x0, x1}) {
    building.plan.rooms.push_back({Vector2d(x, -length) - h, Vector2d(x, length) + h});
  }
  add_hall(building, {x0 + width / 4, -half - kHallWider}, {x1 - width / 4, half + kHallWider});
  const Vector2d x(1, 0), y(0, 1);
  furnish(building, {{x0 - half, -length}, y, -x, 2 * length}, 0);
  furnish(building, {{x1 + half, -length}, y, x, 2 * length}, 1);
  furnish(building, {{x0, length + half}, x, y, width}, 0);
  furnish(building, {{x0, -length - half}, x, -y, width}, 2);
  const double block = length - 2 * half;
  for (const double from : {-length + half, half}) {
    furnish(building, {{x0 + half, from}, y, x, block}, from < 0 ? 1 : 2);
    furnish(building, {{x1 - half, from}, y, -x, block}, from < 0 ? 2 : 1);
  }
  return building;
}

}  // namespace

FloorPlan walk_plan(const InertialSettings& settings) { return make_building(settings).plan; }

std::vector<Box> walk_furniture(const InertialSettings& settings) {
  return make_building(settings).furniture;
}

Plan drawn_walk_plan(const InertialSettings& settings) {
  const Building building = make_building(settings);
  Plan plan;
  for (auto& loop : wall_loops(plan_walls(building.plan))) {
    plan.push_back({.kind = PlanLine::Kind::kWall, .points = std::move(loop)});
  }
  for (const Box& box : building.furniture) {
    if (box.low.z() > building.floor) continue;  // a lintel: one walks below it
    const Vector2d low = box.low.head<2>(), high = box.high.head<2>();
    plan.push_back({.kind = PlanLine::Kind::kFurniture,
                    .points = {low, {high.x(), low.y()}, high, {low.x(), high.y()}, low}});
  }
  return plan;
}

}  // namespace chasles
