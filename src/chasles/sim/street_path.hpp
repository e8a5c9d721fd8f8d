#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/sim/street_settings.hpp>

namespace chasles {

/// A straight (turn = 0) or a corner of the path.
struct PathPiece {
  double start = 0;                             ///< distance along the path at its start [m]
  double length = 0;                            ///< [m]
  Eigen::Vector2d p = Eigen::Vector2d::Zero();  ///< its start [m]
  double heading = 0;                           ///< at its start [rad]
  double turn = 0;                              ///< change of heading over the piece [rad]
};

/// The path on the map: straights and corners in turn, starting and ending with a straight. The
/// heading in a corner is a smoothstep of the distance, so the curvature has two continuous
/// derivatives everywhere.
struct StreetPath {
  std::vector<PathPiece> pieces;
  double length = 0;                       ///< [m]
  std::vector<Eigen::Vector2i> crossings;  ///< crossings on the route, in blocks from the first one
};

/// A point of the path.
struct PathPoint {
  Eigen::Vector2d p;  ///< [m]
  double heading;     ///< [rad], 0 along x, growing to the left, not wrapped
  double curvature;   ///< d heading / d distance [1/m]
};

/// The route through the grid of crossings, starting at the origin along x. Throws UsageError if a
/// corner does not fit into a block or its street.
StreetPath make_street_path(const StreetSettings& settings);

/// The point at the distance `way` [m], 0 <= way <= path.length. Straights are in closed form; in a
/// corner the integral of (cos, sin) of the heading is computed by 40-point Gauss-Legendre
/// quadrature, to round-off.
PathPoint point_at(const StreetPath& path, double way);

}  // namespace chasles
