#pragma once

#include <Eigen/Core>

namespace chasles {

/// A place on the Earth.
struct Geodetic {
  double latitude = 0, longitude = 0;  ///< [deg], north and east
  double altitude = 0;                 ///< [m], above the recording's reference
};

/// The place of a world's origin on the Earth. The world's x axis points east, y north, z up, in
/// the Mercator projection of a sphere (radius 6378137 m) at the scale of the origin's latitude.
/// This is KITTI's convention (Geiger et al. 2013).
struct Georeference {
  Geodetic origin;
};

/// The projection [m]: to_world(g, g.origin) is zero.
Eigen::Vector3d to_world(const Georeference& georeference, const Geodetic& place);

/// Its inverse.
Geodetic to_geodetic(const Georeference& georeference, const Eigen::Vector3d& p_world);

}  // namespace chasles
