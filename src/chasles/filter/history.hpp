#pragma once

#include <functional>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include <chasles/filter/state.hpp>

namespace chasles {

/// A landmark of the whole map.
struct MapLandmark {
  LandmarkId id = 0;
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();     ///< [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< additive error, world axes [m^2]
  int observations = 0;                                  ///< used, the first included
};

/// What a filter did, as the linear maps of its errors: enough to tell afterwards what all
/// measurements together say of a landmark that has left the state. One entry costs memory in
/// proportion to the landmarks in view, never to the map (docs/map.md).
///
/// An error is true minus estimated, in the reference chart, with the core's rows first and three
/// rows for every landmark of the state, in order.
class History {
 public:
  /// The errors of the core moved: d+ = F d + w, w of covariance Q.
  struct Propagation {
    Eigen::MatrixXd F, Q;
  };
  /// Measurements of errors d, and the step d+ = A (d - delta) that the filter made on them.
  struct Correction {
    struct OfLandmark {
      int index = 0;                          ///< in the state
      Eigen::Matrix<double, 6, 3> with_pose;  ///< H_pose^T R^-1 H_landmark
      Eigen::Matrix3d own;                    ///< H_landmark^T R^-1 H_landmark
      Eigen::Vector3d vector;                 ///< H_landmark^T R^-1 r
    };
    Eigen::MatrixXd core;         ///< sum of H_core^T R^-1 H_core
    Eigen::VectorXd core_vector;  ///< sum of H_core^T R^-1 r
    std::vector<OfLandmark> landmarks;
    Eigen::VectorXd delta;
    Eigen::MatrixXd A_motion;     ///< A's block on the rows of pose and v_world; empty: identity
    Eigen::MatrixXd A_landmarks;  ///< A's columns of the rotation in the landmarks' rows: 3n x 3
  };
  /// Landmarks began: their errors are d_pose times the pose's, plus noise.
  struct Addition {
    Eigen::MatrixXd d_pose;  ///< 3k x 6
    Eigen::MatrixXd noise;   ///< 3 x 3k, block by block
  };
  /// Landmarks left the state.
  struct Removal {
    std::vector<int> indices;  ///< in the state, rising
    std::vector<Landmark> landmarks;
  };
  using Step = std::variant<Propagation, Correction, Addition, Removal>;

  explicit History(const Eigen::MatrixXd& core_covariance) : initial_(core_covariance) {}

  void append(Step step);
  int removed() const { return removed_; }

  /// All removed landmarks, in the order of removal, as all measurements up to now have them.
  std::vector<MapLandmark> landmarks() const;

  /// The covariance of all removed landmarks, of the landmarks of the state and, last, of the core,
  /// by block rows of the lower triangle: visit(r, block) has rows r … r + block.rows() of the
  /// columns 0 … r + block.rows().
  using RowVisitor = std::function<void(Eigen::Index row, const Eigen::MatrixXd& block)>;
  void visit_covariance(const RowVisitor& visit) const;

 private:
  Eigen::MatrixXd initial_;
  std::vector<Step> steps_;
  int state_landmarks_ = 0;
  int removed_ = 0;
};

}  // namespace chasles
