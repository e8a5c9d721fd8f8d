#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

/// A point of the map that the filter may still observe.
struct Landmark {
  LandmarkId id = 0;
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  ///< [m]
  int row = 0;           ///< where its three errors stand in the error vector
  int observations = 0;  ///< used so far, the one that began it included
};

/// The mean of the filter. Its error vector is
///
///   [ pose: rotation 3, position 3 | v_world 3, if there is one | additive | landmarks, 3 each ]
///
/// where the part before the landmarks is called the core. What the numbers of the error mean is
/// the business of the error chart (error_chart.hpp); `additive` states and biases are additive in
/// all.
struct State {
  SE3 world_T_imu;
  std::optional<Eigen::Vector3d> v_world;  ///< [m/s]; only the inertial motion model has it
  Eigen::VectorXd additive;                ///< the motion model's own: body velocity, biases, scale
  std::vector<Landmark> landmarks;         ///< in view or kept waiting; rows rise

  int additive_row() const { return v_world ? 9 : 6; }
  int core_size() const { return additive_row() + static_cast<int>(additive.size()); }
};

}  // namespace chasles
