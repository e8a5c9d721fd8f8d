#pragma once

#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/run_folder/run.hpp>

namespace chasles {

// Messages of a map. Landmarks that are not finite are left out.

/// foxglove.PointCloud, with `sigma` [m] and colours of it.
nlohmann::json map_cloud(const std::vector<RunLandmark>& landmarks, Time time);
/// foxglove.SceneUpdate of the landmarks' 95 % ellipsoids.
nlohmann::json map_ellipsoids(const std::vector<RunLandmark>& landmarks, Time time);

/// A landmark's covariance as an ellipsoid: its axes, and its 95 % semi-axes [m].
struct Ellipsoid {
  Eigen::Matrix3d axes;  ///< columns, a rotation
  Eigen::Vector3d radii;
};
Ellipsoid ellipsoid_95(const Eigen::Matrix3d& covariance);

}  // namespace chasles
