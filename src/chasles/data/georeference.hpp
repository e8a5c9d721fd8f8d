#pragma once

#include <Eigen/Core>

namespace chasles {

/// A place on the Earth.
struct Geodetic {
  double latitude = 0, longitude = 0;  ///< [deg], north and east
  double altitude = 0;                 ///< [m], as the recording counts it
};

/// Where a world's origin is on the Earth; its x axis points east, y north, z up, by Mercator's
/// projection of a sphere (radius 6378137 m) at the scale of the origin's latitude: KITTI's own
/// convention (Geiger et al. 2013).
struct Georeference {
  Geodetic origin;
};

/// The projection [m]: to_world(g, g.origin) is zero.
Eigen::Vector3d to_world(const Georeference& georeference, const Geodetic& place);

/// Its inverse.
Geodetic to_geodetic(const Georeference& georeference, const Eigen::Vector3d& p_world);

}  // namespace chasles
