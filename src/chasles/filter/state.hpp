#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/anchor_face.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/lens_coefficients.hpp>
#include <chasles/camera/rolling_shutter.hpp>
#include <chasles/imu/imu_correction.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

/// A past pose in the state, kept for observations still to be used or as the anchor of landmarks.
/// It is constant in time and estimated together with all other states.
struct Clone {
  int id = 0;
  Time time{};
  SE3 world_T_imu;
  int row = 0;     ///< first row of its six errors [rotation; position] in the error vector
  SE3 first = {};  ///< the pose when it was cloned
  ReadoutMotion readout = {};  ///< after this pose
};

/// Parameters of a camera as random constants. Their errors are additive, and six rows each:
/// [fx, fy, cx, cy, readout, 0], and six coefficients of the lens model at a time. Nothing depends
/// on rows without a parameter, and on those of known ones; they have a variance, which keeps the
/// covariance regular.
struct Intrinsics {
  Eigen::Vector4d projection = Eigen::Vector4d::Zero();  ///< fx, fy, cx, cy [px]
  double readout = 0;                                    ///< [s]; 0 stays 0
  LensCoefficients coefficients = {};
  bool has_lens = true, has_readout = true;  ///< whether they have errors; else they are known

  static constexpr int kReadoutRow = 4;  ///< of the first six
  int blocks() const { return 1 + (static_cast<int>(coefficients.size()) + 5) / 6; }
};

/// A point of the map in the state, in one of two forms: Cartesian, or anchored inverse depth,
/// (x/z, y/z, 1/z) in a camera of a clone, or where its ray is beside or behind that camera, in the
/// axes of another face (camera/anchor_face.hpp).
struct Landmark {
  LandmarkId id = 0;
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  ///< [m]; Cartesian form
  int row = 0;                     ///< first row of its three errors in the error vector
  int observations = 0;            ///< used so far, including the one of its initialisation
  std::optional<int> anchor = {};  ///< the clone's id; none: the Cartesian form
  SE3 cam_T_imu = {};  ///< of the anchor's camera, at the line of its pixel and in the axes of the
                       ///< face; the estimate, if estimated
  Eigen::Vector3d inverse_depth = Eigen::Vector3d::Zero();  ///< [1, 1, 1/m]; anchored form
  Eigen::Vector3d first = Eigen::Vector3d::Zero();  ///< world position at initialisation [m]
  int camera = 0;  ///< the anchor's; index into State::imu_T_camera if those are estimated
  std::optional<int> considered = {};  ///< its number in Ekf::past(), if of a ConsideredMap
  SE3 imu_T_line = {};  ///< of the pixel that anchors it (camera/rolling_shutter.hpp)
  AnchorFace face = AnchorFace::kFront;  ///< of the anchor's camera

  /// Whether its depth is positive: noise may move an inverse depth through zero.
  bool has_place() const { return !anchor || inverse_depth.z() > 0; }

  /// The three parameters that its errors change.
  Eigen::Vector3d& parameters() { return anchor ? inverse_depth : p_world; }
  const Eigen::Vector3d& parameters() const { return anchor ? inverse_depth : p_world; }
};

/// A map from elsewhere that no update changes (Ekf::consider). The errors that its landmarks share
/// are rows of the error vector, so that they count with their cross-covariances.
struct ConsideredMap {
  int frame = 0;         ///< its number in Ekf::past()
  int row = 0;           ///< first row of the shared errors; those of the frame are the last ones
  Eigen::VectorXd mean;  ///< of the shared errors: updates correct those of the frame alone
  /// Landmarks that were in the state: p_world is that of the filter's map axes when they left.
  std::vector<Landmark> away = {};
};

/// Linearisation point of a measurement.
enum class Linearisation {
  kCurrent,  ///< the current estimates
  /// The first estimate of every landmark and clone, and the predicted pose: unobservable
  /// directions then stay unobservable (Huang, Mourikis & Roumeliotis, "first-estimates Jacobians";
  /// docs/derivations.md, D57).
  kFirstEstimates,
};

/// The point p_world / w [m]. Noise may move the inverse depth w of a distant point, or of one with
/// an assumed depth, through zero. Such a point has no position, but a direction, and therefore a
/// projection.
struct HomogeneousPoint {
  Eigen::Vector3d p_world;
  double w = 1;
};

/// The mean of the filter. Its error vector is
///
///   [ pose: rotation 3, position 3 | v_world 3, if present | nav_T_world 6, if present:
///     rotation, position | additive | imu_T_camera 6 each, if present: rotation, position |
///     time_offset 1, if present | intrinsics, 6 a block, if present | imu, if present |
///     landmarks, 3 each, clones, 6 each, and the shared errors and landmarks of a considered map,
///     in order of addition ]
///
/// where the part before the landmarks is called the core. The error chart (error_chart.hpp)
/// defines the error coordinates. In all charts the errors of `additive`, of the time offset and of
/// the IMU's parameters are additive. The errors of nav_T_world and of each imu_T_camera are R =
/// Exp(psi) Rhat, p = phat + dp (Kleinert & Stilla, eq. 17), in nav axes and IMU axes respectively.
///
/// With a time_offset, world_T_imu, v_world and the clones refer to the instants at which the
/// images were taken, regardless of the offset (calibration.hpp).
struct State {
  SE3 world_T_imu;
  std::optional<Eigen::Vector3d> v_world;  ///< [m/s]; only in the inertial motion model
  std::optional<SE3> nav_T_world = {};     ///< if the attitude of the world is estimated
  Eigen::VectorXd additive;            ///< states of the motion model: body velocity, biases, scale
  std::vector<SE3> imu_T_camera = {};  ///< of every camera; empty: not estimated
  std::optional<double> time_offset = {};   ///< camera clock + time_offset = IMU clock [s]
  std::vector<Intrinsics> intrinsics = {};  ///< of every camera; empty: not estimated
  std::optional<ImuCorrection> imu = {};    ///< parameters of the IMU; none: known
  std::vector<Landmark> landmarks = {};     ///< not retired; rows rise
  std::vector<Clone> clones = {};           ///< rows rise
  std::optional<ConsideredMap> considered = {};
  ReadoutMotion readout = {};  ///< after world_T_imu; known, without errors

  int motion_size() const { return v_world ? 9 : 6; }  ///< rows of pose and v_world
  int nav_row() const { return motion_size(); }
  int additive_row() const { return motion_size() + (nav_T_world ? 6 : 0); }
  int calibration_row() const { return additive_row() + static_cast<int>(additive.size()); }
  int calibration_size() const {
    int size = 6 * static_cast<int>(imu_T_camera.size()) + (time_offset ? 1 : 0);
    for (const Intrinsics& one : intrinsics) size += 6 * one.blocks();
    return size + (imu ? imu->size() : 0);
  }
  /// First row of a camera's six errors; none if they are not estimated.
  std::optional<int> camera_row(int camera) const {
    if (camera >= static_cast<int>(imu_T_camera.size())) return std::nullopt;
    return calibration_row() + 6 * camera;
  }
  int time_offset_row() const {
    return calibration_row() + 6 * static_cast<int>(imu_T_camera.size());
  }
  /// First row of a camera's intrinsics; none if they are not estimated.
  std::optional<int> intrinsics_row(int camera) const {
    if (camera >= static_cast<int>(intrinsics.size())) return std::nullopt;
    int row = time_offset_row() + (time_offset ? 1 : 0);
    for (int i = 0; i < camera; ++i) row += 6 * intrinsics[static_cast<std::size_t>(i)].blocks();
    return row;
  }
  int core_size() const { return calibration_row() + calibration_size(); }
  /// First row of the errors of the IMU's parameters, the last ones of the core; with `imu`.
  int imu_row() const { return core_size() - imu->size(); }
  /// All rows.
  int size() const {
    int rows = core_size();
    if (!landmarks.empty()) rows = std::max(rows, landmarks.back().row + 3);
    if (!clones.empty()) rows = std::max(rows, clones.back().row + 6);
    if (considered) {
      rows = std::max(rows, considered->row + static_cast<int>(considered->mean.size()));
      for (const Landmark& landmark : considered->away) rows = std::max(rows, landmark.row + 3);
    }
    return rows;
  }

  /// The clone with this id, which must exist.
  const Clone& clone(int id) const {
    return *std::find_if(clones.begin(), clones.end(), [&](const Clone& c) { return c.id == id; });
  }
  HomogeneousPoint homogeneous(const Landmark& landmark) const;
  /// World position of a landmark of either form [m].
  Eigen::Vector3d p_world(const Landmark& landmark) const {
    if (!landmark.anchor) return landmark.p_world;
    const HomogeneousPoint point = homogeneous(landmark);
    return point.p_world / point.w;
  }
};

/// d homogeneous(landmark).p_world / d (errors of the anchor, reference chart; inverse depth) of an
/// anchored landmark; w is the last of these nine coordinates.
Eigen::Matrix<double, 3, 9> homogeneous_derivative(const Clone& anchor, const Landmark& landmark);

/// d homogeneous(landmark).p_world / d (errors of the anchor's imu_T_camera) of the same.
Eigen::Matrix<double, 3, 6> homogeneous_derivative_by_camera(const Clone& anchor,
                                                             const Landmark& landmark);

/// The same two derivatives of p_world(landmark). The inverse depth must not be zero
/// (docs/derivations.md, D47).
Eigen::Matrix<double, 3, 9> anchored_derivative(const Clone& anchor, const Landmark& landmark);
Eigen::Matrix<double, 3, 6> anchored_derivative_by_camera(const Clone& anchor,
                                                          const Landmark& landmark);

}  // namespace chasles
