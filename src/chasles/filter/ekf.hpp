#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/filter/covariance.hpp>
#include <chasles/filter/measurement.hpp>
#include <chasles/filter/past/kept_past.hpp>
#include <chasles/filter/past/past_view.hpp>
#include <chasles/filter/present_landmark.hpp>
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
/// leaves the state and causes no further cost. past() gives its mean and covariance on request,
/// equal to those of a filter over the whole map (docs/map.md). Charts act on the state only: the
/// error of a retired landmark is additive. The filter keeps its workspace: with a constant state
/// size it allocates no heap memory. Use a filter from one thread at a time, including its const
/// functions.
class Ekf {
 public:
  using Map = KeptPast::Map;
  struct Options {
    Map map = Map::kHistory;
    Past::Options past = {};  ///< with Map::kPast
    /// True: the scale of all distances, which pixels alone cannot observe, stays unobservable to
    /// them when the mean changes (docs/filter.md, section 3). Requires v_world, not
    /// Map::kHistory, and a chart whose pose errors do not rotate with the pose: not left-se3.
    bool keep_scale = false;
    /// Rows of the core that are considered: no update corrects them, and their uncertainty counts
    /// (Schmidt-Kalman filter, docs/inertial.md). Sorted.
    std::vector<int> considered = {};
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

  /// Standard deviation of the relative error of scale that the landmarks of the state have in
  /// common (docs/filter.md, section 3). None without keep_scale, or if no landmark has a known
  /// depth.
  std::optional<double> scale_sigma() const;

  /// r^T S^-1 r of some measurements together; infinite where S is not positive definite.
  double joint_normalised_square(std::span<const Measurement> measurements) const;

  /// The motion after the current pose, for cameras with a rolling shutter. Clones keep it.
  void set_readout(const ReadoutMotion& motion) { state_.readout = motion; }

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
  /// Map::kHistory or without nav_T_world.
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

  /// Past landmarks (numbers of past(), rising) return to the end of the state, with their exact
  /// covariance with all other states, as if they had not left. Throws UsageError for a number
  /// that cannot return, as without past.recalls.
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

  /// These past landmarks (numbers of past()) do not return: the return of others costs less.
  void bar_return(std::span<const int> numbers);

  /// What is known now of the states that have left, and of the whole map.
  PastView past() const { return {past_, state_, covariance_}; }

  /// The position of a landmark of the state (index into State::landmarks), with its covariance.
  MapLandmark landmark(int index) const {
    return as_of_now(state_, covariance_, state_.landmarks[static_cast<std::size_t>(index)]);
  }

 private:
  // Has no meaning between two calls, except for the report.
  struct Workspace {
    UpdateReport report;
    std::vector<const Measurement*> accepted;
    State before;
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
  void gate(std::span<const Measurement> measurements) const;
  void correct_mean(State& x, const ErrorRef& delta) const;
  void change_chart(const State& before);
  bool change_chart_by_rotation(const State& before, Eigen::Ref<Eigen::MatrixXd> B);
  void change_chart_of_motion(const KeptPast::MotionMatrix& A);
  void change_chart_of_clones(const State& before);
  void add_rotation_of_clone(int row, const Eigen::Matrix3d& D);
  void turn_clone(int row, const Matrix6d& A);
  bool change_of_scale(const State& before, Eigen::Ref<Eigen::VectorXd> by,
                       Eigen::Ref<Eigen::VectorXd> c) const;
  void add_outer(const dense::ConstBlock& U, const dense::ConstBlock& V);
  std::optional<Eigen::VectorXd> scale_error(std::span<const Landmark> landmarks) const;
  void leave_unused(const Whitened& z, Eigen::Ref<Eigen::VectorXd> delta);
  void leave_considered(const Whitened& z, Eigen::Ref<Eigen::VectorXd> delta);
  void substitute(int row, std::span<const KeptPast::RowTerm> terms);
  void to_map_axes(Landmark& landmark);
  void to_world_axes(Landmark& landmark);
  void revive_others(const std::vector<int>& numbers);
  void revive_considered(const std::vector<int>& numbers);
  void follow_the_changes(std::span<const Eigen::Vector3d> as_they_left);
  void move_to_present_mean(const Eigen::Vector3d& as_it_left, const Landmark& landmark,
                            const std::optional<Eigen::VectorXd>& scale);
  void keep_rows();

  const ErrorChart* chart_;
  bool keep_scale_;
  std::vector<int> considered_;
  State state_;
  Covariance covariance_;
  KeptPast past_;
  mutable Workspace work_;
};

}  // namespace chasles
