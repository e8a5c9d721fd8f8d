#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <chasles/report/against_truth.hpp>

namespace chasles {

/// The coordinates of the filter's error, from the chart in a summary (JSON).
PoseError coordinates_of(const std::string& summary);

/// against_truth() of a running run: each state is compared once, when it arrives. Two things
/// differ from the final comparison. The first matched pose alone aligns the truth, also for
/// `world_T_truth_fit`. With Pairing::kNearest a state takes the nearest true pose within half the
/// spacing of the states before it, or of the true poses if that is smaller.
class GrowingComparison {
 public:
  GrowingComparison() = default;
  GrowingComparison(Trajectory truth, const TruthPairing& pairing, PoseError coordinates,
                    bool level);

  /// Compares the run's new states. Does nothing before the second state.
  void extend(const std::vector<RunState>& states);

  /// Whether a state has been matched with a true pose.
  bool started() const { return world_T_truth_.has_value(); }
  const Trajectory& truth() const { return truth_; }

  /// The true pose of a state in the run's world; none where none was matched.
  const std::optional<SE3>& truth_of(std::size_t state) const { return placed_[state]; }
  /// Places the truth in the run's world. Presumes started().
  const SE3& world_T_truth() const { return *world_T_truth_; }
  /// Number of states that were compared.
  std::size_t size() const { return error_.size(); }

  /// The comparison of these states, in the given order. Presumes started().
  AgainstTruth of(const std::vector<std::size_t>& states) const;

 private:
  std::optional<SE3> true_pose(const RunState& state, Time tolerance) const;
  void add(const RunState& state, Time tolerance);

  Trajectory truth_;
  TruthPairing pairing_;
  PoseError coordinates_ = PoseError::kStandard;
  bool level_ = false;
  Time truth_spacing_{};
  std::optional<SE3> world_T_truth_;
  std::vector<Vector6d> error_;  ///< per state; NaN without a true pose
  std::vector<PoseNees> nees_;
  std::vector<std::optional<SE3>> placed_;  ///< true poses in the run's world
};

}  // namespace chasles
