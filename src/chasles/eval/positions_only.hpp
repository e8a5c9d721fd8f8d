#pragma once

#include <span>

#include <chasles/eval/nees.hpp>

// Estimates against a truth of positions alone.
namespace chasles {

/// Whether a truth has the same rotation throughout while the estimate turns by more than 5
/// degrees, as the positions of a total station with a unit quaternion behind them.
bool is_without_attitudes(const Trajectory& estimate, const Trajectory& truth);

/// truth_T_estimate for NEES of the position: the first positions coincide, and the rotation
/// between the worlds (`level`: the heading) is fitted to all positions. `matched`: at least one
/// row.
SE3 first_position_alignment(const MatchedTrajectories& matched, bool level);

/// nees() for such a truth, with that alignment. The fitted rotation hides a part of the error.
/// Only the position's values are filled: those of attitude and pose are NaN, and their summaries
/// have no count.
Nees position_nees(const MatchedTrajectories& matched, std::span<const Matrix6d> covariances,
                   bool level);

}  // namespace chasles
