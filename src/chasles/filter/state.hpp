#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

/// A past pose that the filter keeps, because observations made from it are still to be used or an
/// anchored landmark hangs on it. It does not move, but it is estimated with all else.
struct Clone {
  int id = 0;
  Time time{};
  SE3 world_T_imu;
  int row = 0;     ///< where its six errors [rotation; position] stand in the error vector
  SE3 first = {};  ///< the pose as it was when it was cloned
};

/// A point of the map that the filter may still observe, in one of two forms: Cartesian, or
/// anchored inverse depth, (x/z, y/z, 1/z) in a camera of a clone.
struct Landmark {
  LandmarkId id = 0;
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  ///< [m]; Cartesian form
  int row = 0;                     ///< where its three errors stand in the error vector
  int observations = 0;            ///< used so far, the one that began it included
  std::optional<int> anchor = {};  ///< the clone's id; none: the Cartesian form
  SE3 cam_T_imu = {};              ///< of the anchor's camera, as estimated where it is
  Eigen::Vector3d inverse_depth = Eigen::Vector3d::Zero();  ///< [1, 1, 1/m]; anchored form
  Eigen::Vector3d first = Eigen::Vector3d::Zero();          ///< where it was when it began [m]
  int camera = 0;  ///< the anchor's, an index into State::imu_T_camera where those are estimated

  /// Whether its depth is one: noise may take an inverse depth through zero.
  bool has_place() const { return !anchor || inverse_depth.z() > 0; }

  /// What its three errors change.
  Eigen::Vector3d& parameters() { return anchor ? inverse_depth : p_world; }
  const Eigen::Vector3d& parameters() const { return anchor ? inverse_depth : p_world; }
};

/// At which values a measurement is linearised.
enum class Linearisation {
  kCurrent,  ///< the present estimates
  /// The first estimate of every landmark and clone, the prediction of the pose: what nothing can
  /// observe then stays so (Huang, Mourikis & Roumeliotis, "first-estimates Jacobians";
  /// docs/derivations.md, D57).
  kFirstEstimates,
};

/// The point p_world / w [m]. Noise may take the inverse depth of a point that is far, or guessed
/// to be, through zero: such a point has no place, but a direction, in which cameras see it.
struct HomogeneousPoint {
  Eigen::Vector3d p_world;
  double w = 1;
};

/// The mean of the filter. Its error vector is
///
///   [ pose: rotation 3, position 3 | v_world 3, if there is one | nav_T_world 6, if there is one:
///     rotation, position | additive | imu_T_camera 6 each, if there are any: rotation, position |
///     time_offset 1, if there is one | landmarks, 3 each, and clones, 6 each, as they came ]
///
/// where the part before the landmarks is called the core. What the numbers of the error mean is
/// the business of the error chart (error_chart.hpp). In all charts `additive` states, biases and
/// the time offset are additive, and the errors of nav_T_world and of each imu_T_camera are
/// R = Exp(psi) Rhat, p = phat + dp (Kleinert & Stilla, eq. 17), in nav's and the IMU's axes.
///
/// With a time_offset, world_T_imu, v_world and the clones are those of the instants at which the
/// images were taken, whatever the offset is (calibration.hpp).
struct State {
  SE3 world_T_imu;
  std::optional<Eigen::Vector3d> v_world;  ///< [m/s]; only the inertial motion model has it
  std::optional<SE3> nav_T_world = {};     ///< where the world's own attitude is estimated
  Eigen::VectorXd additive;                ///< the motion model's own: body velocity, biases, scale
  std::vector<SE3> imu_T_camera = {};      ///< of every camera; empty: they are known
  std::optional<double> time_offset = {};  ///< camera clock + time_offset = IMU clock [s]
  std::vector<Landmark> landmarks = {};    ///< in view or kept waiting; rows rise
  std::vector<Clone> clones = {};          ///< rows rise

  int motion_size() const { return v_world ? 9 : 6; }  ///< rows of pose and v_world
  int nav_row() const { return motion_size(); }
  int additive_row() const { return motion_size() + (nav_T_world ? 6 : 0); }
  int calibration_row() const { return additive_row() + static_cast<int>(additive.size()); }
  int calibration_size() const {
    return 6 * static_cast<int>(imu_T_camera.size()) + (time_offset ? 1 : 0);
  }
  /// Of a camera's six errors; none where they are not estimated.
  std::optional<int> camera_row(int camera) const {
    if (camera >= static_cast<int>(imu_T_camera.size())) return std::nullopt;
    return calibration_row() + 6 * camera;
  }
  int time_offset_row() const {
    return calibration_row() + 6 * static_cast<int>(imu_T_camera.size());
  }
  int core_size() const { return calibration_row() + calibration_size(); }
  /// All rows.
  int size() const {
    int rows = core_size();
    if (!landmarks.empty()) rows = std::max(rows, landmarks.back().row + 3);
    if (!clones.empty()) rows = std::max(rows, clones.back().row + 6);
    return rows;
  }

  /// The clone of that id, which must be there.
  const Clone& clone(int id) const {
    return *std::find_if(clones.begin(), clones.end(), [&](const Clone& c) { return c.id == id; });
  }
  HomogeneousPoint homogeneous(const Landmark& landmark) const;
  /// Where a landmark of either form is [m].
  Eigen::Vector3d p_world(const Landmark& landmark) const {
    if (!landmark.anchor) return landmark.p_world;
    const HomogeneousPoint point = homogeneous(landmark);
    return point.p_world / point.w;
  }
};

/// d homogeneous(landmark).p_world / d (errors of the anchor, reference chart; inverse depth) of an
/// anchored landmark; w is the last of the nine itself.
Eigen::Matrix<double, 3, 9> homogeneous_derivative(const Clone& anchor, const Landmark& landmark);

/// d homogeneous(landmark).p_world / d (errors of the anchor's imu_T_camera) of the same.
Eigen::Matrix<double, 3, 6> homogeneous_derivative_by_camera(const Clone& anchor,
                                                             const Landmark& landmark);

/// The same two of p_world(landmark), whose inverse depth must not be zero (docs/derivations.md,
/// D47).
Eigen::Matrix<double, 3, 9> anchored_derivative(const Clone& anchor, const Landmark& landmark);
Eigen::Matrix<double, 3, 6> anchored_derivative_by_camera(const Clone& anchor,
                                                          const Landmark& landmark);

}  // namespace chasles
