#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <chasles/report/against_truth.hpp>

namespace chasles {

/// against_truth() of a run that still grows: each state is compared once, when it comes. What
/// needs all states is not there: the truth is placed by the first matched pose alone, also as
/// `world_T_truth_fit`, and a state takes the nearest true pose within half the distance of the
/// states before it (or of the true poses, where those are nearer to each other).
class GrowingComparison {
 public:
  GrowingComparison() = default;
  GrowingComparison(Trajectory truth, PoseError coordinates, bool level);

  /// Compares those of the run's states that it does not know yet. Does nothing before the second.
  void extend(const std::vector<RunState>& states);

  /// A state and a true pose are known to belong together.
  bool begun() const { return world_T_truth_.has_value(); }
  const Trajectory& truth() const { return truth_; }

  /// Of those states, in that order. Presumes begun().
  AgainstTruth of(const std::vector<std::size_t>& states) const;

 private:
  std::optional<SE3> true_pose(const RunState& state, Time tolerance) const;
  void add(const RunState& state, Time tolerance);

  Trajectory truth_;
  PoseError coordinates_ = PoseError::kStandard;
  bool level_ = false;
  Time truth_spacing_{};
  std::optional<SE3> world_T_truth_;
  std::vector<Vector6d> error_;  ///< a state; NaN where it has no true pose
  std::vector<PoseNees> nees_;
};

}  // namespace chasles
