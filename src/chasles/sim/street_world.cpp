#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include <chasles/sim/street_world.hpp>

namespace chasles {
namespace {

struct Interval {
  double enter, leave;
};

// The part of the line from + t * ray that lies in the block, seen from above; empty (enter >
// leave) where it misses.
Interval inside(const Block& block, const Eigen::Vector2d& from, const Eigen::Vector2d& ray) {
  Interval result{-std::numeric_limits<double>::infinity(),
                  std::numeric_limits<double>::infinity()};
  for (int axis = 0; axis < 2; ++axis) {
    if (ray[axis] == 0) {
      if (from[axis] < block.low[axis] || from[axis] > block.high[axis]) return {1, 0};
      continue;
    }
    const double a = (block.low[axis] - from[axis]) / ray[axis];
    const double b = (block.high[axis] - from[axis]) / ray[axis];
    result.enter = std::max(result.enter, std::min(a, b));
    result.leave = std::min(result.leave, std::max(a, b));
  }
  return result;
}

std::optional<double> cast_on_facades(const StreetWorld& world, const Eigen::Vector3d& from,
                                      const Eigen::Vector3d& ray) {
  std::optional<double> nearest;
  for (const Block& block : world.blocks) {
    const Interval part = inside(block, from.head<2>(), ray.head<2>());
    if (part.enter > part.leave || part.enter <= 0) continue;
    if (!nearest || part.enter < *nearest) nearest = part.enter;
  }
  return nearest;
}

std::optional<double> cast_on_road(const StreetWorld& world, const Eigen::Vector3d& from,
                                   const Eigen::Vector3d& ray) {
  if (ray.z() >= 0) return std::nullopt;
  // Newton's method from the mean road. A ray so flat that a wave occludes its end does not
  // converge and counts as meeting nothing.
  double t = (world.ground - from.z()) / ray.z();
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d p = from + t * ray;
    const double gap = p.z() - world.ground - world.road.height(p.head<2>());
    if (std::abs(gap) < 1e-9) return t > 0 ? std::optional(t) : std::nullopt;
    t -= gap / (ray.z() - world.road.gradient(p.head<2>()).dot(ray.head<2>()));
  }
  return std::nullopt;
}

}  // namespace

StreetWorld make_street_world(const StreetSettings& settings, const StreetDrive& drive) {
  StreetWorld world{.blocks = {},
                    .road = drive.road,
                    .ground = -settings.imu_height,
                    .roof = settings.facade_height - settings.imu_height};
  std::set<std::pair<int, int>> cells;
  for (const Eigen::Vector2i& crossing : drive.path.crossings) {
    for (const auto& [i, j] :
         std::to_array<std::pair<int, int>>({{-1, -1}, {-1, 0}, {0, -1}, {0, 0}})) {
      cells.emplace(crossing.x() + i, crossing.y() + j);
    }
  }
  const Eigen::Array2d size(settings.block_length, settings.block_width);
  for (const auto& [i, j] : cells) {
    const Eigen::Array2d low = size * Eigen::Array2d(i, j) + settings.street_width / 2;
    const Eigen::Array2d high = size * Eigen::Array2d(i + 1, j + 1) - settings.street_width / 2;
    if ((low < high).all()) world.blocks.push_back({low.matrix(), high.matrix()});
  }
  return world;
}

std::optional<double> cast(const StreetWorld& world, const Eigen::Vector3d& from,
                           const Eigen::Vector3d& ray) {
  const auto facade = cast_on_facades(world, from, ray);
  const auto road = cast_on_road(world, from, ray);
  if (road && (!facade || *road < *facade)) return road;
  if (facade && from.z() + *facade * ray.z() <= world.roof) return facade;
  return std::nullopt;
}

bool blocked(const StreetWorld& world, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  // A point on a façade does not occlude itself.
  constexpr double kBefore = 1 - 1e-6;
  const Eigen::Vector3d ray = to - from;
  return std::ranges::any_of(world.blocks, [&](const Block& block) {
    const Interval part = inside(block, from.head<2>(), ray.head<2>());
    return std::max(part.enter, 0.0) < std::min(part.leave, kBefore);
  });
}

}  // namespace chasles
