#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/filter/covariance.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/measurement.hpp>
#include <chasles/filter/past/history.hpp>
#include <chasles/filter/past/latest_segment.hpp>
#include <chasles/filter/past/past.hpp>
#include <chasles/filter/scratch.hpp>
#include <chasles/filter/state.hpp>
#include <chasles/filter/whitening.hpp>

namespace chasles {

/// What a filter keeps of its past: the landmarks and poses that have left its state, and what is
/// needed to know them as well as all measurements allow. The filter records each of its steps
/// here, with the errors d of its state in the reference chart. PastView has the answers.
class KeptPast {
 public:
  /// What becomes of the landmarks that leave the state (docs/map.md).
  enum class Map {
    kFrozen,   ///< each keeps its mean and covariance; later measurements do not change them
    kHistory,  ///< map() has what later measurements say about them; no clones, calibration or nav
    kPast,     ///< so has estimates(), of poses too; they can return into the state
    kDense,    ///< they stay in one dense covariance, at a cost that grows (compress_map=false)
  };
  struct Options {
    Map map = Map::kHistory;
    Past::Options past = {};    ///< with Map::kPast
    std::size_t map_bytes = 0;  ///< bound on the memory of the steps, with Map::kHistory; 0: none
  };
  /// d * (three errors of the state that begin at a row).
  struct RowTerm {
    int row = 0;
    Eigen::Matrix3d d;
  };
  /// Of the rows of pose and v_world.
  using MotionMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 9, 9>;

  KeptPast(const Eigen::MatrixXd& core_covariance, Options options);

  /// Throws UsageError with Map::kHistory, whose steps are few: "`what` a filter without …".
  void reject_with_history(const char* what) const;

  /// Propagation of the core's errors, d+ = F d + w with w of covariance Q. `covariance`: before.
  void propagate(const Eigen::MatrixXd& F, const Eigen::MatrixXd& Q, const Covariance& covariance);

  /// An update: its measurements, its result, and the correction of the mean. The changes of the
  /// chart that come with it follow, then end_correction().
  void correct(Measurements used, const Whitened& update, const ErrorRef& delta);
  /// d+ = d + U V^T d. With Map::kHistory, V = [I 0]^T: by the rotation of the pose.
  void add_outer(const dense::ConstBlock& U, const dense::ConstBlock& V);
  /// The position's errors of the clone at a row gain D times those of its rotation.
  void add_rotation_of_clone(int row, const Eigen::Matrix3d& D);
  void turn_clone(int row, const Matrix6d& A);
  void turn_motion(const MotionMatrix& A);
  void end_correction();

  /// Three rows gain by c^T d.
  void add_along(const Eigen::VectorXd& c, int row, const Eigen::Vector3d& by);
  /// Three rows become the sum of the terms.
  void substitute(int row, std::span<const RowTerm> terms);
  /// An anchored landmark becomes Cartesian, by derivatives J by its clone and its inverse depth,
  /// and J_camera by its camera, if that is estimated.
  void make_cartesian(int row, int clone_row, const Eigen::Matrix<double, 3, 9>& J,
                      std::optional<int> camera_row, const Eigen::Matrix<double, 3, 6>& J_camera);
  /// The world frame moves: d+ = J d.
  void compose(const SE3& imu_T_world, const dense::ConstBlock& J_transposed);

  /// The state has further errors: a copy of the pose, those of new landmarks from row `first` on,
  /// a function D d of the present ones.
  void clone_pose();
  void add(std::span<const NewLandmark> landmarks, int first);
  void append_function(const Eigen::MatrixXd& D_transposed);
  /// The state keeps these errors. The indices must rise.
  void keep_rows(const std::vector<int>& rows) { latest_.keep_rows(rows); }

  /// Whether landmarks leave in the Cartesian form and in the axes of the map.
  bool is_in_map_axes() const { return map_ == Map::kPast || map_ == Map::kDense; }
  /// A landmark of the state leaves, in the form that is_in_map_axes() demands; then, before they
  /// are removed from the state, the indices of all that leave together (rising).
  void leave(const Landmark& landmark, const State& x, const Covariance& covariance);
  void end_leaving(std::span<const int> indices, const State& x);

  /// Ekf::remember_pose.
  void remember_pose(Time time, const State& x, const Covariance& covariance);
  void remember_pose(Time time, const SE3& map_T_imu, const Eigen::MatrixXd& d_core,
                     const Covariance& covariance);

  /// Ekf::revive: the past landmarks are the last rows of a state with this covariance so far.
  void check_can_return(std::span<const int> numbers) const;
  Carried revive(const std::vector<int>& numbers, const Covariance& covariance);
  void bar_return(int number) { left_.bar_return(number); }

  /// Ekf::add_past, with a state of this covariance.
  int add_past(PriorMap prior, const Covariance& covariance);
  /// Ekf::consider: the shared errors are further rows of the state.
  int consider(PriorMap prior);
  /// Landmarks of a considered map return, and one leaves.
  void note_returned(std::span<const int> numbers);
  void note_left(int number) { left_.note_left(number); }

  /// Cross-covariance of the past's variables with the errors of the state (LatestSegment::Z).
  Eigen::Block<const Eigen::MatrixXd> Z() const { return latest_.Z(); }

  Map map() const { return map_; }
  const Past& left() const { return left_; }
  const LatestSegment& latest() const { return latest_; }
  const History& history() const { return history_; }
  const std::vector<MapLandmark>& frozen() const { return frozen_; }

 private:
  bool keeps_steps() const { return map_ == Map::kHistory; }
  void end_segment_when_due(const Covariance& covariance);
  void check_fits(const PriorMap& prior) const;
  void add_dense(const PriorMap& prior, Eigen::Index n);
  void record(Measurements used, const ErrorRef& delta);
  void record(std::span<const NewLandmark> landmarks);

  Map map_;
  Eigen::Index core_;               ///< rows of the core
  LatestSegment latest_;            ///< the steps since the last segment
  Past left_;                       ///< states that have left, and the segments until then
  History history_;                 ///< all steps, with Map::kHistory
  History::Correction correction_;  ///< of the present update
  std::vector<MapLandmark> frozen_;
  Scratch product_, other_;
};

}  // namespace chasles
