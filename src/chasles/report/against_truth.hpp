#pragma once

#include <string>
#include <vector>

#include <chasles/data/run.hpp>
#include <chasles/eval/association.hpp>
#include <chasles/eval/nees.hpp>

namespace chasles {

/// The truth brought into the run's world, and what the estimate lacks of it.
struct AgainstTruth {
  MatchedTrajectories matched;
  Nees nees;  ///< of each matched row, in the coordinates asked for
  /// Places truth by the first matched pose, of a run that is_level() by its position and heading
  /// alone: as nees() does.
  SE3 world_T_truth_first;
  SE3 world_T_truth_fit;  ///< places truth by the best rigid fit, as the ATE does
  /// Truth minus estimate at each state, truth placed by world_T_truth_first: [theta; dp] as
  /// RunState::pose_covariance, [rad, m]. NaN where no truth was matched.
  std::vector<Vector6d> error;
  /// `nees` at each state; NaN where there is no error or the covariance is singular.
  std::vector<double> nees_pose, nees_attitude, nees_position;
  /// Why nothing could be compared; empty when it could. Then the placements are the identity.
  std::string problem;
};

/// The comparison of eval/, by matched row and laid out by state, of the states whose poses are
/// finite.
AgainstTruth against_truth(const Run& run, PoseError nees_coordinates = PoseError::kStandard);

}  // namespace chasles
