#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include <chasles/filter/covariance.hpp>
#include <chasles/filter/past/past.hpp>
#include <chasles/filter/state.hpp>

namespace chasles {

/// The steps of a filter as linear maps of its errors. From them, the estimate of a removed
/// landmark given all measurements can be computed afterwards. The memory of one step is
/// proportional to the landmarks in view, not to the map (docs/map.md). With a bound on the memory
/// the oldest steps are given up in time: the landmarks removed in them are then final.
///
/// An error is true minus estimated, in the reference chart. The core's rows come first, then three
/// rows for every landmark of the state, in order.
class History {
 public:
  /// Propagation of the core's errors: d+ = F d + w, w of covariance Q.
  struct Propagation {
    Eigen::MatrixXd F, Q;
  };
  /// Measurements of the errors d, and the filter's correction d+ = A (d - delta).
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
  /// Landmarks were initialised: their errors are d_pose times the pose's, plus noise.
  struct Addition {
    Eigen::MatrixXd d_pose;  ///< 3k x 6
    Eigen::MatrixXd noise;   ///< 3 x 3k, block by block
  };
  /// Landmarks were removed from the state.
  struct Removal {
    std::vector<int> indices;  ///< in the state, rising
    std::vector<Landmark> landmarks;
  };
  /// The pose at this time is remembered: the first six errors.
  struct Pose {
    Time time{};
    SE3 world_T_imu;
  };
  using Step = std::variant<Propagation, Correction, Addition, Removal, Pose>;

  /// `most_bytes`: the bound on the memory of the steps; 0: none. Evaluating them takes about as
  /// much again.
  explicit History(const Eigen::MatrixXd& core_covariance, std::size_t most_bytes = 0)
      : core_(core_covariance.rows()), initial_(core_covariance), most_bytes_(most_bytes) {}

  void append(Step step);
  /// Keeps the bound: gives up the older half of the steps where it is reached. `covariance`: of
  /// the errors d after all steps so far.
  void keep_bound(const Covariance& covariance);
  std::size_t bytes() const { return bytes_; }  ///< of the steps
  bool is_complete() const { return steps_given_up_ == 0; }
  int removed() const { return removed_; }

  /// All removed landmarks, in the order of removal, and all remembered poses, estimated from all
  /// measurements so far; final ones from those before the older half of the steps was given up.
  Past::Estimates estimates() const;

  /// The covariance of all removed landmarks, of the landmarks of the state and, last, of the core,
  /// by block rows of the lower triangle: visit(r, block) has rows r … r + block.rows() of the
  /// columns 0 … r + block.rows(). Requires is_complete().
  using RowVisitor = std::function<void(Eigen::Index row, const Eigen::MatrixXd& block)>;
  void visit_covariance(const RowVisitor& visit) const;

 private:
  /// Between the older and the younger half.
  struct Middle {
    std::size_t steps = 0, bytes = 0;  ///< of the older half
    Eigen::MatrixXd covariance;        ///< of d
  };

  void give_up_older_half();

  Eigen::Index core_;
  Eigen::MatrixXd initial_;  ///< covariance of d before the first step
  std::size_t most_bytes_, bytes_ = 0;
  std::vector<Step> steps_;
  std::optional<Middle> middle_;
  Past::Estimates final_;
  std::size_t steps_given_up_ = 0;
  int state_landmarks_ = 0;
  int removed_ = 0;
};

}  // namespace chasles
