#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/base/time.hpp>
#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/filter/past/past.hpp>
#include <chasles/loop/appearance.hpp>
#include <chasles/loop/joint_covariance.hpp>

namespace chasles {

/// A landmark of a map, as it is recognised.
struct MapPoint {
  Eigen::Vector3d p_map = Eigen::Vector3d::Zero();  ///< [m]
  int session = 0;                                  ///< that began it
  int observations = 0;                             ///< used, including the first
  Appearance appearance = {};
};

/// A run that contributed to a map.
struct MapSession {
  std::string name;             ///< of the recording
  Time begin{}, end{};          ///< of its estimates
  std::vector<Camera> cameras;  ///< with the calibration that the run had at its end
};

/// Landmarks with their appearance and their joint covariance: what a run leaves for another one.
/// The frame is that of the first session's run, with the z axis up; nothing in it is uncertain.
struct LandmarkMap {
  std::vector<MapSession> sessions;
  std::vector<MapPoint> points;
  JointCovariance covariance;
};

/// A corner that is found again is not quite the same point [px].
inline constexpr double kOtherPoint = 1.5;
/// Bits of a descriptor that may differ where the place is known, of 256: 128 differ by chance.
inline constexpr int kSimilarBits = 50;

/// Ids of a map's landmarks in a run begin here: its own tracks have smaller ones.
inline constexpr LandmarkId kFirstMapId = 1'000'000'000;

/// Where a map lies in the world of a run, as it is known before its landmarks are observed. The
/// sigmas weigh nothing beside observations: the place is where these are linearised. With sigmas
/// of 0 the place is known: the world is that of the map.
struct MapPlace {
  SE3 world_T_map;
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();  ///< world; the heading's error turns about it
  double heading_sigma = 0.3;                       ///< [rad]
  double position_sigma = 5;                        ///< of the pivot [m]
};

/// Some points of a map in the world of a run. The ids are kFirstMapId + index. The last four
/// shared errors are those of the place: heading and position.
PriorMap placed(const LandmarkMap& map, std::span<const int> points, const MapPlace& place);

}  // namespace chasles
