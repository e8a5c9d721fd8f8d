#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/filter/covariance.hpp>
#include <chasles/filter/measurement.hpp>
#include <chasles/filter/past/history.hpp>
#include <chasles/filter/past/latest_segment.hpp>
#include <chasles/filter/past/past.hpp>
#include <chasles/filter/scratch.hpp>
#include <chasles/filter/state.hpp>

namespace chasles {

/// Result of an update.
struct UpdateReport {
  double nis = 0;              ///< r^T S^-1 r of all accepted measurements together
  int dof = 0;                 ///< rows of r
  std::vector<bool> accepted;  ///< by the gate, for each measurement
  /// L^-1 r of each measurement separately, S = L L^T: unit variance if the filter is consistent.
  /// Empty for a measurement without a gate.
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>> whitened;
  /// S of each measurement separately; empty for one without a gate.
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>> covariances;
  bool failed = false;  ///< S was not positive definite: the state is unchanged
};

/// The predicted mean of the core and its linearisation: d next = F d now + noise of covariance Q
/// (reference chart; F and Q are core_size x core_size).
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
/// leaves the state and causes no further cost. The history of the filter's steps gives its mean
/// and covariance on request, equal to those of a filter over the whole map (docs/map.md). Charts
/// act on the state only: the error of a retired landmark is additive. The filter keeps its
/// workspace: with a constant state size it allocates no heap memory. Use a filter from one thread
/// at a time, including its const functions.
class Ekf {
 public:
  /// What becomes of the landmarks that leave the state (docs/map.md).
  enum class Map {
    kFrozen,   ///< each keeps its mean and covariance; later measurements do not change them
    kHistory,  ///< map() has what later measurements say about them; no clones, calibration or nav
    kPast,     ///< so has past_estimates(), of poses too; they can return into the state
    kDense,    ///< they stay in one dense covariance, at a cost that grows: a reference for tests
  };
  struct Options {
    Map map = Map::kHistory;
    Past::Options past = {};  ///< with Map::kPast
    /// True: the scale, which pixels alone cannot observe, stays unobservable to them when the mean
    /// changes (docs/filter.md, section 3). Requires v_world, not Map::kHistory, and a chart whose
    /// pose errors do not rotate with the pose: not left-se3.
    bool keep_scale = false;
    /// Bound on the memory of the steps from which the map is computed, with Map::kHistory [bytes];
    /// 0: none.
    std::size_t map_bytes = 0;
  };

  /// Throws UsageError for incompatible options.
  Ekf(const ErrorChart& chart, State initial, const Eigen::MatrixXd& core_covariance,
      Options options);

  const State& state() const { return state_; }
  const ErrorChart& chart() const { return *chart_; }

  /// Covariance of the core's errors, reference chart.
  Eigen::MatrixXd core_covariance() const;
  /// Covariance of all errors of the state, in the row order of State, reference chart.
  Covariance::ConstBlock covariance() const { return covariance_.all(); }

  void propagate(const Prediction& prediction);

  /// Adds noise to the parameters of a landmark of the state (index into State::landmarks), because
  /// the observed point moves. Throws UsageError with Map::kHistory.
  void add_noise(int landmark, const Eigen::Matrix3d& noise);

  /// residual^T S^-1 residual of a single measurement: the value that its gate tests.
  double normalised_square(const Measurement& measurement) const;

  /// The same for many measurements, each as if `given`, which depends on the core only, had been
  /// applied before: a precise velocity reduces S. Null: without it.
  std::vector<double> normalised_squares(std::span<const Measurement> measurements,
                                         const Measurement* given) const;

  /// Gates each measurement separately, then applies all accepted ones in one block. A measurement
  /// of a landmark may depend on the landmark and the pose only. The report is valid until the next
  /// update.
  const UpdateReport& update(std::span<const Measurement> measurements);

  /// The mean after update(), which is not made: a better point to linearise at. None where the
  /// gate accepts nothing, or S is not positive definite.
  std::optional<State> updated_mean(std::span<const Measurement> measurements) const;

  /// r^T S^-1 r of some measurements together; infinite where S is not positive definite.
  double joint_normalised_square(std::span<const Measurement> measurements) const;

  /// Adds a copy of the current pose as a clone. Throws UsageError with Map::kHistory.
  void clone_pose(int id, Time time);
  /// Removes clones; no landmark may be anchored on them.
  void remove_clones(std::span<const int> ids);

  /// Converts an anchored landmark (index into State::landmarks) to the Cartesian form: a change of
  /// coordinates. Useful once its depth is accurate: it then no longer needs its clone.
  void make_cartesian(int index);
  /// Standard deviation of the inverse depth of an anchored landmark [1/m].
  double inverse_depth_sigma(const Landmark& landmark) const;

  /// Kleinert & Stilla's composition step: moves the world frame to the current IMU frame, exactly.
  /// The information on the pose goes to nav_T_world and to all states in world coordinates
  /// (docs/derivations.md, D52). No predicted measurement or NIS changes. Throws UsageError with
  /// keep_map or without nav_T_world.
  void compose();

  void add(std::span<const NewLandmark> landmarks);

  /// Moves landmarks (indices into State::landmarks, rising) from the state to the map.
  void retire(std::span<const int> indices);

  /// Removes landmarks (indices into State::landmarks, rising) from state and map. Throws
  /// UsageError with Map::kHistory.
  void remove(std::span<const int> indices);

  /// Remembers the present pose, or another linear function of the core, as a past pose: map_T_imu
  /// with d_core, the derivative of its errors [rotation; position] by the core's (6 x core_size).
  /// Throws UsageError with Map::kFrozen; the second also with kHistory.
  void remember_pose(Time time);
  void remember_pose(Time time, const SE3& map_T_imu, const Eigen::MatrixXd& d_core);

  /// Past landmarks (numbers of past(), rising) with all that is known now: their covariance, that
  /// with the errors of the state, and the corrections of their means since they left. Requires
  /// past.recalls.
  Carried recall(std::span<const int> numbers) const;

  /// Past landmarks (numbers of past(), rising) return to the end of the state, with their exact
  /// covariance with all other states, as if they had not left. Throws UsageError for a number
  /// that cannot return (Past::can_return), as without past.recalls.
  void revive(std::span<const int> numbers);

  /// Landmarks from elsewhere become past landmarks, which can return. Returns the number of the
  /// map's frame in past(); those of the landmarks follow. Throws UsageError without past.recalls,
  /// and for a covariance that does not fit.
  int add_past(PriorMap prior);

  /// The same, but the map is known from a better source than this run: its landmarks are
  /// considered, with all their covariances, and no update changes them (Schmidt-Kalman filter,
  /// docs/filter.md). Updates correct the frame of the map, by prior.of_frame. The shared errors
  /// become rows of the state, and so do landmarks that have once returned. Throws UsageError also
  /// for a second map.
  int consider(PriorMap prior);

  /// What recall() gives, and the landmarks of the state (indices) in the axes of the map after
  /// them: items with the number -1, whose corrections are their positions.
  Carried recall(std::span<const int> numbers, std::span<const int> landmarks) const;

  /// These past landmarks (numbers of past()) do not return: the return of others costs less.
  void marginalise(std::span<const int> numbers);

  /// The estimates of all past states and of the landmarks in the state, given all measurements.
  /// With Map::kPast it requires past.records.
  Past::Estimates past_estimates() const;
  const Past& past() const { return past_; }

  /// The position of a landmark of the state (index into State::landmarks), with its covariance.
  MapLandmark landmark(int index) const {
    return as_of_now(state_.landmarks[static_cast<std::size_t>(index)]);
  }

  /// Memory of the steps from which the map is computed.
  std::size_t map_bytes() const { return history_.bytes(); }

  /// Number of landmarks in the whole map: retired ones and those in the state. Landmarks with a
  /// non-positive inverse depth have no position and do not count.
  int map_size() const;

  /// The current estimate of the whole map: retired landmarks in the order of retirement, then
  /// those of the state; with Map::kPast and kDense in nav axes where nav_T_world is a state, else
  /// in world axes. The computing time is proportional to the length of the history.
  std::vector<MapLandmark> map() const;

  /// The covariance of the whole map in the order of map(), 3 rows each, followed by the core, by
  /// block rows of the lower triangle: visit(r, block) has rows r … r + block.rows() of the columns
  /// 0 … r + block.rows(). The visitor decides what to store: the lower triangle for 8,000
  /// landmarks takes 2.3 GB. Throws UsageError where a bound on the memory has removed steps.
  void visit_map_covariance(const History::RowVisitor& visit) const;

 private:
  // Has no meaning between two calls, except for the report.
  struct Workspace {
    UpdateReport report;
    std::vector<const Measurement*> accepted;
    State before;
    std::vector<Landmark> gone;
    std::vector<int> rows;
    struct Rows {
      int* first;
      int width;
    };
    std::vector<Rows> kept;
    WhiteningScratch whitening;
    Scratch delta, xi, product, other, B, Z;
  };

  Innovation innovation(const Measurement& measurement) const;
  void correct_mean(State& x, const ErrorRef& delta) const;
  void change_chart(const State& before, History::Correction& record);
  void change_chart_of_clones(const State& before);
  void keep_scale(const State& before);
  bool remembers() const { return options_.map == Map::kHistory; }
  bool has_past() const { return options_.map == Map::kPast || options_.map == Map::kDense; }
  struct RowTerm {
    int row = 0;
    Eigen::Matrix3d d;
  };
  void substitute(int row, std::span<const RowTerm> terms);
  MapLandmark in_map_axes(const Landmark& landmark) const;
  Eigen::Matrix<double, 3, Eigen::Dynamic> derivative_in_map_axes(const Landmark& landmark) const;
  void to_map_axes(Landmark& landmark);
  void to_world_axes(Landmark& landmark);
  void add_dense(const PriorMap& prior);
  void check_fits(const PriorMap& prior) const;
  bool is_considered(int number) const;
  std::pair<std::vector<int>, std::vector<int>> apart(std::span<const int> numbers) const;
  Eigen::Vector3d considered_place(const State& x, int number) const;
  void put_considered_in_place(State& x, const ErrorRef& delta) const;
  /// What an update would have measured of a considered map: P is larger by D D^T, and D w is not
  /// corrected. `rows` are those of D in the error vector.
  struct Unused {
    std::vector<int> rows;
    Eigen::MatrixXd D;
  };
  Unused unused_gain(const Whitened& z) const;
  void leave_unused(const Whitened& z, Eigen::Ref<Eigen::VectorXd> delta);
  /// Past states of a considered map as linear functions of the errors of the state.
  struct OfState {
    std::vector<Segment::Item> items;
    Eigen::MatrixXd d, own;
    Eigen::VectorXd correction;
  };
  OfState considered_of_state(std::span<const int> numbers) const;
  Carried recall_considered(std::span<const int> considered, const Carried& others) const;
  void revive_considered(std::span<const int> numbers);
  void drop_considered(int number);
  void append_considered(Past::Estimates& estimates) const;
  void leave(std::span<const int> indices);
  void end_segment_when_due();
  void move_to_present_mean(const Eigen::Vector3d& as_it_left, const Landmark& landmark,
                            const std::optional<Eigen::VectorXd>& scale);
  std::optional<Eigen::VectorXd> scale_error(std::span<const Landmark> landmarks) const;
  void keep_rows();
  void add_to_latest(std::span<const NewLandmark> landmarks, int first);
  void visit_dense_covariance(const History::RowVisitor& visit) const;
  MapLandmark as_of_now(const Landmark& landmark) const;
  void gate(std::span<const Measurement> measurements) const;
  void remember(const std::vector<const Measurement*>& used, const ErrorRef& delta,
                History::Correction& record) const;

  const ErrorChart* chart_;
  Options options_;
  State state_;
  Covariance covariance_;
  LatestSegment latest_;  ///< past states, and what they need
  Past past_;
  History history_;
  std::vector<MapLandmark> frozen_;
  mutable Workspace work_;
};

}  // namespace chasles
