#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <chasles/lie/se3.hpp>
#include <chasles/loop/appearance.hpp>
#include <chasles/loop/landmark_map.hpp>

namespace chasles {

/// A landmark that a camera sees now.
struct PlacePoint {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  ///< its estimate [m]
  PatchView view;                                     ///< as it looks, in the world's axes
};

/// Where a map lies in the world of a run.
struct PlaceInMap {
  struct Match {
    int seen = 0;   ///< index of a PlacePoint
    int point = 0;  ///< index of a MapPoint
  };
  SE3 world_T_map;
  std::vector<Match> matches;  ///< that agree with it; each seen and each map's point once
};

/// Finds the place of a map from the appearance of what a camera at p_world sees. World and map
/// have a vertical z axis, so four numbers are unknown. None where too few points agree, or nearly
/// as many agree with another place. A proposal: what it says is to be tested
/// (docs/recognition.md).
std::optional<PlaceInMap> find_place(std::span<const PlacePoint> seen,
                                     const Eigen::Vector3d& p_camera, const LandmarkMap& map);

}  // namespace chasles
