#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/base/time.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

/// A landmark of a saved map, as it is shown. A row of prior_map.csv.
struct SketchPoint {
  LandmarkId id = 0;                                     ///< its number in a run that uses the map
  int session = 0;                                       ///< index of the session that began it
  Eigen::Vector3d p_map = Eigen::Vector3d::Zero();       ///< frame of the map [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< axes of the map [m^2]
  double own = 1;  ///< share of the covariance's trace that no other landmark has, 0 to 1
  int observations = 0, views = 0;
};

/// A run that contributed to a saved map.
struct SketchSession {
  std::string name;     ///< of the recording
  Time begin{}, end{};  ///< of its estimates
  int cameras = 0;
};

/// What pages and viewers show of a saved map: everything but descriptors and correlations.
struct MapSketch {
  SE3 world_T_map;  ///< of a run that has found its place in the map, at its end
  std::vector<SketchSession> sessions;
  std::vector<SketchPoint> points;
};

}  // namespace chasles
