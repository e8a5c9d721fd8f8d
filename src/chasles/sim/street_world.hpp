#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/sim/street_drive.hpp>

namespace chasles {

/// A block of houses on the map: opaque, with façades on its four sides.
struct Block {
  Eigen::Vector2d low, high;  ///< its corners [m]
};

/// The visible world: the road, everywhere, and the blocks of houses.
struct StreetWorld {
  std::vector<Block> blocks;
  Road road;
  double ground = 0;  ///< height of the road's mean [m]
  double roof = 0;    ///< height of the façades' upper edge [m]
};

/// The blocks around every crossing of the path.
StreetWorld make_street_world(const StreetSettings& settings, const StreetDrive& drive);

/// The first intersection of a ray with a façade or the road: point = from + t * ray, t > 0;
/// nothing if the ray meets the sky. A façade behind the roof of a nearer block counts as sky.
std::optional<double> cast(const StreetWorld& world, const Eigen::Vector3d& from,
                           const Eigen::Vector3d& ray);

/// Whether a block is between two points in top view (roofs occlude everything behind them).
bool blocked(const StreetWorld& world, const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace chasles
