#include <algorithm>
#include <cmath>

#include <chasles/numeric/random.hpp>
#include <chasles/sim/render_world.hpp>
#include <chasles/sim/texture_paint.hpp>
#include <chasles/sim/walk_path.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLampEvery = 3.5;        // [m], in rooms up to the height of 4 m
constexpr double kLampBelow = 0.3;        // [m], the ceiling
constexpr double kCameraClearance = 0.8;  // [m]

void add_upright(const Vector2d& left, const Vector2d& right, double low, double high,
                 Material material, std::vector<Surface>& surfaces) {
  const Vector2d along = right - left;
  surfaces.push_back({.corner = {left.x(), left.y(), high},
                      .right = {along.x(), along.y(), 0},
                      .down = {0, 0, low - high},
                      .material = material});
}

// A horizontal rectangle, visible from above or from below.
void add_level(const Vector2d& low, const Vector2d& high, double z, bool from_above,
               Material material, std::vector<Surface>& surfaces) {
  const Vector2d size = high - low;
  surfaces.push_back({.corner = {low.x(), from_above ? high.y() : low.y(), z},
                      .right = {size.x(), 0, 0},
                      .down = {0, from_above ? -size.y() : size.y(), 0},
                      .material = material});
}

void add_box(const Box& box, std::vector<Surface>& surfaces) {
  const Vector2d a = box.low.head<2>(), c = box.high.head<2>();
  const Vector2d b(c.x(), a.y()), d(a.x(), c.y());
  for (const auto& [left, right] : {std::pair{a, b}, {b, c}, {c, d}, {d, a}}) {
    add_upright(left, right, box.low.z(), box.high.z(), Material::kBox, surfaces);
  }
  add_level(a, c, box.high.z(), true, Material::kBox, surfaces);
  add_level(a, c, box.low.z(), false, Material::kBox, surfaces);
}

void add_lamps(const PlanRectangle& tile, double floor, double ceiling,
               std::vector<Vector3d>& lamps) {
  const Vector2d size = tile.high - tile.low;
  if (size.minCoeff() < 0.9) return;
  const double every = kLampEvery * std::max(1.0, (ceiling - floor) / 4);
  const int columns = std::max(1, static_cast<int>(size.x() / every));
  const int rows = std::max(1, static_cast<int>(size.y() / every));
  for (int i = 0; i < columns * rows; ++i) {
    const double x = tile.low.x() + (i % columns + 0.5) * size.x() / columns;
    const double y = tile.low.y() + (static_cast<double>(i / columns) + 0.5) * size.y() / rows;
    lamps.emplace_back(x, y, ceiling - kLampBelow);
  }
}

RenderWorld hallway(const InertialSettings& settings) {
  const Hallway hall = make_hallway(settings);
  const Vector2d a = hall.outer.low.head<2>(), b = hall.inner.low.head<2>();
  const Vector2d c = hall.inner.high.head<2>(), d = hall.outer.high.head<2>();
  const FloorPlan plan{
      .rooms = {
          {a, {d.x(), b.y()}}, {{a.x(), c.y()}, d}, {a, {b.x(), d.y()}}, {{c.x(), a.y()}, d}}};
  return furnished(plan, hall.outer.low.z(), hall.outer.high.z(), {});
}

RenderWorld turntable(const InertialSettings& settings) {
  const double wide = settings.circle_radius + settings.radial_sway + 3;
  const double high = settings.vertical_sway + settings.cube_edge / 2 + 2.5;
  const Vector3d half = Vector3d::Constant(settings.cube_edge / 2);
  return furnished({.rooms = {{{-wide, -wide}, {wide, wide}}}}, -high, high, {Box{-half, half}});
}

std::vector<Vector3d> way(const Spline& motion) {
  std::vector<Vector3d> points;
  const double step = std::max(0.05, motion.duration / 20000);
  for (double t = 0; t <= motion.duration; t += step) {
    points.push_back(motion_at(motion, t).world_T_imu.p);
  }
  return points;
}

double distance(const Box& box, const Vector3d& p) {
  return (p - p.cwiseMax(box.low).cwiseMin(box.high)).norm();
}

bool apart(const Box& a, const Box& b) {
  return ((a.low - b.high).array() > 0.3).head<2>().any() ||
         ((b.low - a.high).array() > 0.3).head<2>().any();
}

// A pillar, a crate, or a cupboard at a wall.
Box drawn(const Box& room, Dice& dice) {
  const Vector2d low = room.low.head<2>(), high = room.high.head<2>();
  const int sort = dice.choice(3);
  Vector2d size;
  for (double& edge : size) edge = sort == 0 ? dice.between(0.25, 0.5) : dice.between(0.5, 1.4);
  Vector2d at;
  for (int i = 0; i < 2; ++i) at[i] = dice.between(low[i] + 0.4, high[i] - 0.4 - size[i]);
  if (sort == 2) {
    const int axis = dice.choice(2);
    at[axis] = dice.chance(0.5) ? low[axis] : high[axis] - size[axis];
  }
  const double space = room.high.z() - room.low.z();
  const double height = sort == 0 ? space : std::min(dice.between(0.5, 2.2), space);
  return {{at.x(), at.y(), room.low.z()},
          {at.x() + size.x(), at.y() + size.y(), room.low.z() + height}};
}

std::vector<Box> furniture_beside(const std::vector<Vector3d>& points, const Box& room,
                                  std::uint64_t seed) {
  constexpr std::uint64_t kPlaces = 0xf0000000;
  const Vector2d size = (room.high - room.low).head<2>();
  const auto wanted = static_cast<std::size_t>(std::min(60.0, size.prod() / 5));
  Dice dice(seed, kPlaces);
  std::vector<Box> boxes;
  for (int tries = 0; tries < 2000 && boxes.size() < wanted; ++tries) {
    const Box box = drawn(room, dice);
    const bool free = std::ranges::all_of(
        points, [&](const Vector3d& p) { return distance(box, p) > kCameraClearance; });
    if (free && std::ranges::all_of(boxes, [&](const Box& b) { return apart(box, b); })) {
      boxes.push_back(box);
    }
  }
  return boxes;
}

RenderWorld room_about(const Spline& motion, std::uint64_t seed) {
  const std::vector<Vector3d> points = way(motion);
  Box room{points.front(), points.front()};
  for (const Vector3d& p : points) {
    room.low = room.low.cwiseMin(p);
    room.high = room.high.cwiseMax(p);
  }
  const Vector2d extent = (room.high - room.low).head<2>();
  const Vector2d margin = ((8 - extent.array()) / 2).max(3.0);
  room.low -= Vector3d(margin.x(), margin.y(), 1);
  room.high += Vector3d(margin.x(), margin.y(), 1.8);
  return furnished({.rooms = {{room.low.head<2>(), room.high.head<2>()}}}, room.low.z(),
                   room.high.z(), furniture_beside(points, room, seed));
}

}  // namespace

RenderWorld furnished(const FloorPlan& plan, double floor, double ceiling,
                      const std::vector<Box>& furniture) {
  RenderWorld world{.plan = plan,
                    .floor = floor,
                    .ceiling = ceiling,
                    .furniture = furniture,
                    .surfaces = {},
                    .lamps = {}};
  for (const WallSegment& wall : plan_walls(plan)) {
    // The free space is to the left of the direction from a to b: the viewer sees b to the left of
    // a.
    add_upright(wall.b, wall.a, floor, ceiling, Material::kWall, world.surfaces);
  }
  for (const PlanRectangle& tile : plan_floors(plan)) {
    add_level(tile.low, tile.high, floor, true, Material::kFloor, world.surfaces);
    add_level(tile.low, tile.high, ceiling, false, Material::kCeiling, world.surfaces);
    add_lamps(tile, floor, ceiling, world.lamps);
  }
  for (const Box& box : furniture) add_box(box, world.surfaces);
  return world;
}

RenderWorld make_render_world(const InertialSettings& settings, const Spline& motion) {
  if (settings.geometry == Geometry::kHallway) return hallway(settings);
  if (settings.geometry == Geometry::kTurntable) return turntable(settings);
  if (settings.geometry == Geometry::kTrajectory) return room_about(motion, settings.seed);
  return furnished(walk_plan(settings), -settings.imu_height,
                   settings.corridor_height - settings.imu_height, walk_furniture(settings));
}

}  // namespace chasles
