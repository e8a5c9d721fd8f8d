#pragma once

#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <chasles/filter/state.hpp>

namespace chasles {

/// One measurement, linearised at the current mean in the reference chart: residual = z - h(x). It
/// depends on the errors of a range of core columns, of one landmark, and of `clones`. `noise` must
/// be regular.
struct Measurement {
  /// Derivative of the predicted measurement by six further errors: those of a clone, or of an
  /// imu_T_camera.
  struct OfClone {
    int row = 0;  ///< of the six
    Eigen::Matrix<double, Eigen::Dynamic, 6, 0, 6, 6> d;
  };

  static constexpr int kMaxCoreColumns = 19;

  int landmark = -1;    ///< index into State::landmarks; -1: none
  int core_column = 0;  ///< first column of d_core in the core
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> residual;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, kMaxCoreColumns> d_core;
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 6, 3> d_landmark;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> noise;
  double gate = std::numeric_limits<double>::infinity();  ///< on residual^T S^-1 residual
  /// A part of the diagonal of `noise` that the gate leaves out of S: for errors that many
  /// measurements share. A measurement that disagrees with the others cannot have it from them.
  double shared_variance = 0;
  std::vector<OfClone> clones = {};  ///< the same six errors may occur twice

  /// As new, but that `clones` keep their room.
  void clear() {
    std::vector<OfClone> room = std::move(clones);
    room.clear();
    *this = {};
    clones = std::move(room);
  }
};

/// A landmark to initialise, with the derivative of its position (of its inverse depth, if it is
/// anchored) by the errors of pose, clones and imu_T_camera (reference chart), and the covariance
/// from the noise of its own observations.
struct NewLandmark {
  struct OfClone {
    int row = 0;  ///< of the six
    Eigen::Matrix<double, 3, 6> d;
  };

  LandmarkId id = 0;
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, 6> d_pose = Eigen::Matrix<double, 3, 6>::Zero();
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
  std::vector<OfClone> clones = {};
  int observations = 1;
  int matches = 0;                 ///< of the observations, those that were matched
  std::optional<int> anchor = {};  ///< as in Landmark
  SE3 cam_T_imu = {}, imu_T_line = {};
  Eigen::Vector3d inverse_depth = Eigen::Vector3d::Zero();
  int camera = 0;
  AnchorFace face = AnchorFace::kFront;

  /// As new, but that `clones` keep their room.
  void clear() {
    std::vector<OfClone> room = std::move(clones);
    room.clear();
    *this = {};
    clones = std::move(room);
  }
};

}  // namespace chasles
