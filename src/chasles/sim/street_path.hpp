#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/sim/street_settings.hpp>

namespace chasles {

/// A straight (turn = 0) or a corner of the way.
struct PathPiece {
  double start = 0;                             ///< way driven at its beginning [m]
  double length = 0;                            ///< [m]
  Eigen::Vector2d p = Eigen::Vector2d::Zero();  ///< its beginning [m]
  double heading = 0;                           ///< there [rad]
  double turn = 0;                              ///< change of heading over the piece [rad]
};

/// The way on the map: straights and corners in turn, beginning and ending with a straight. The
/// heading of a corner is a smoothstep of the way driven, so the curvature has two continuous
/// derivatives everywhere.
struct StreetPath {
  std::vector<PathPiece> pieces;
  double length = 0;                       ///< [m]
  std::vector<Eigen::Vector2i> crossings;  ///< passed or turned at, in blocks from the first one
};

/// A point of the way.
struct PathPoint {
  Eigen::Vector2d p;  ///< [m]
  double heading;     ///< [rad], 0 along x, growing to the left, not wrapped
  double curvature;   ///< d heading / d way [1/m]
};

/// The route through the grid of crossings, starting at the origin along x. UsageError where a
/// corner does not fit into a block or its street.
StreetPath make_street_path(const StreetSettings& settings);

/// The point after `way` metres, 0 <= way <= path.length. On straights closed form; within a corner
/// the integral of (cos, sin) of the heading by 40-point Gauss-Legendre quadrature, to round-off.
PathPoint point_at(const StreetPath& path, double way);

}  // namespace chasles
