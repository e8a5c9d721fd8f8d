#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include <chasles/filter/covariance.hpp>
#include <chasles/filter/error_chart.hpp>
#include <chasles/filter/history.hpp>
#include <chasles/filter/measurement.hpp>
#include <chasles/filter/scratch.hpp>
#include <chasles/filter/state.hpp>

namespace chasles {

/// What an update did.
struct UpdateReport {
  double nis = 0;              ///< r^T S^-1 r of all that was used, together
  int dof = 0;                 ///< rows of r
  std::vector<bool> accepted;  ///< by the gate, for each measurement
  /// L^-1 r of each measurement by itself, S = L L^T: of unit variance if the filter is
  /// consistent. Empty for a measurement without a gate.
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>> whitened;
  /// S of each measurement by itself; empty for one without a gate.
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>> covariances;
  bool failed = false;  ///< S was not positive definite: nothing was changed
};

/// The mean of the core a step ahead and its linearisation: d next = F d now + noise of covariance
/// Q (reference chart; core_size x core_size).
struct Prediction {
  SE3 world_T_imu;
  std::optional<Eigen::Vector3d> v_world;
  Eigen::VectorXd additive;
  Eigen::MatrixXd F, Q;
};

/// A residual and its covariance S.
struct Innovation {
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> residual;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> S;

  /// L^-1 residual with S = L L^T; NaN where S is not positive definite.
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> whitened() const;
  double normalised_square() const;
};

/// The extended Kalman filter over the core and the map, in any error chart. A retired landmark
/// leaves the state and costs nothing more; the history of the filter's own steps tells, when
/// asked, its mean and covariance as a filter over the whole map would have them (docs/map.md).
/// Charts act on what is in the state: a retired landmark's error is additive. What it writes on
/// the way it keeps, so that a filter of a constant state asks nothing of the heap; one filter is
/// therefore for one thread at a time, its const functions too.
class Ekf {
 public:
  struct Options {
    /// False: retired landmarks stay in one dense covariance, at a cost that grows with the map:
    /// the oracle of the history.
    bool compress_map = true;
    /// False: a landmark that retires keeps the mean and covariance that it has then, and what is
    /// learnt later does not reach it. Clones, composition and calibration need that.
    bool keep_map = true;
    /// True: what pixels alone cannot tell, the scale of everything, they cannot tell of later
    /// means either (docs/filter.md, section 3). Needs v_world, keep_map = false, and a chart in
    /// which pose errors are not turned by the pose: not left-se3.
    bool keep_scale = false;
  };

  /// Throws UsageError where the options do not go together.
  Ekf(const ErrorChart& chart, State initial, const Eigen::MatrixXd& core_covariance,
      Options options);

  const State& state() const { return state_; }
  const ErrorChart& chart() const { return *chart_; }

  /// Covariance of the core's errors, reference chart.
  Eigen::MatrixXd core_covariance() const;
  /// Covariance of all errors of the state, row by row as State says, reference chart. Without
  /// compress_map also the rows of retired landmarks.
  Covariance::ConstBlock covariance() const { return covariance_.all(); }

  void propagate(const Prediction& prediction);

  /// residual^T S^-1 residual of a measurement by itself: what its gate is held against.
  double normalised_square(const Measurement& measurement) const;

  /// The same for many, each as it would be if `given`, of the core alone, had been applied before:
  /// a precise velocity narrows what an image may show. Null: as they are.
  std::vector<double> normalised_squares(std::span<const Measurement> measurements,
                                         const Measurement* given) const;

  /// Gates each measurement by itself, then applies all that pass in one block. A measurement of a
  /// landmark may depend on the landmark and the pose alone. The report is of the last update.
  const UpdateReport& update(std::span<const Measurement> measurements);

  /// r^T S^-1 r of some measurements together; infinite where S is not positive definite.
  double joint_normalised_square(std::span<const Measurement> measurements) const;

  /// Keeps a copy of the present pose as a clone.
  void clone_pose(int id, Time time);
  /// Lets clones go; no landmark may hang on them.
  void forget_clones(std::span<const int> ids);

  /// An anchored landmark (index into State::landmarks) goes over to the Cartesian form: a change
  /// of coordinates. Worth it once its depth is well known: it no longer needs its clone.
  void make_cartesian(int index);
  /// Of an anchored landmark [1/m].
  double inverse_depth_sigma(const Landmark& landmark) const;

  /// Kleinert & Stilla's composition step: the world's frame is moved to the present IMU frame,
  /// exactly; what was known of the pose goes to nav_T_world, which the state must have, and to all
  /// that stands in the world (docs/derivations.md, D52). No measurement's prediction or NIS is
  /// changed.
  void compose();

  void add(std::span<const NewLandmark> landmarks);

  /// Takes landmarks out of the state (indices into State::landmarks, rising) and into the map.
  void retire(std::span<const int> indices);

  /// Landmarks of the whole map: retired and in the state. Those whose inverse depth is not
  /// positive have no place and are none.
  int map_size() const;

  /// The whole map as known now: in the order of retirement, those of the state last. Takes time in
  /// proportion to the filter's past.
  std::vector<MapLandmark> map() const;

  /// The covariance of the whole map in the order of map(), 3 rows each, and of the core behind it,
  /// by block rows of the lower triangle: visit(r, block) has rows r … r + block.rows() of the
  /// columns 0 … r + block.rows(). Storing them is the visitor's affair:
  /// the lower triangle for 8,000 landmarks takes 2.3 GB.
  void visit_map_covariance(const History::RowVisitor& visit) const;

 private:
  // Of no meaning between two calls, but for the report.
  struct Workspace {
    UpdateReport report;
    std::vector<const Measurement*> accepted;
    State before;
    std::vector<Landmark> gone;
    std::vector<int> rows;
    WhiteningScratch whitening;
    Scratch delta, xi, product, other, B, Z;
  };

  Innovation innovation(const Measurement& measurement) const;
  void correct_mean(const ErrorRef& delta);
  void change_chart(const State& before, History::Correction& record);
  void change_chart_of_clones(const State& before);
  void keep_scale(const State& before);
  bool remembers() const { return options_.compress_map && options_.keep_map; }
  const std::vector<int>& renumber_rows();
  MapLandmark as_of_now(const Landmark& landmark) const;
  void gate(std::span<const Measurement> measurements);
  void remember(const std::vector<const Measurement*>& used, const ErrorRef& delta,
                History::Correction& record) const;

  const ErrorChart* chart_;
  Options options_;
  State state_;
  Covariance covariance_;
  std::vector<Landmark> retired_;  ///< without compress_map: still in the covariance
  History history_;
  std::vector<MapLandmark> forgotten_;  ///< without keep_map
  mutable Workspace work_;
};

}  // namespace chasles
