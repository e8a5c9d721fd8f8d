#pragma once

#include <vector>

#include <chasles/data/run.hpp>
#include <chasles/viewers/channels.hpp>

namespace chasles {

/// Adds /map, a foxglove.PointCloud of the final map with `sigma` [m] and colours of it, and
/// /map/ellipsoids, a foxglove.SceneUpdate of the landmarks' 95 % ellipsoids, both at `time`.
/// Landmarks that are not finite are left out.
void add_map(const std::vector<RunLandmark>& landmarks, Time time, Channels& out);

/// A landmark's covariance as an ellipsoid: its axes, and its 95 % semi-axes [m].
struct Ellipsoid {
  Eigen::Matrix3d axes;  ///< columns, a rotation
  Eigen::Vector3d radii;
};
Ellipsoid ellipsoid_95(const Eigen::Matrix3d& covariance);

}  // namespace chasles
