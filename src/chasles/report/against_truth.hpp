#pragma once

#include <string>
#include <vector>

#include <chasles/eval/association.hpp>
#include <chasles/eval/nees.hpp>
#include <chasles/run_folder/run.hpp>

namespace chasles {

/// The truth in the run's world, and the errors of the estimate.
struct AgainstTruth {
  MatchedTrajectories matched;
  Nees nees;  ///< at each matched row, in the given coordinates
  /// Aligns the truth by the first matched pose; for a run that is_level() by position and heading
  /// of that pose alone, as nees() does.
  SE3 world_T_truth_first;
  SE3 world_T_truth_fit;  ///< aligns the truth by the best rigid fit, as the ATE does
  /// Truth minus estimate at each state, the truth aligned by world_T_truth_first: [theta; dp] as
  /// RunState::pose_covariance, [rad, m]. NaN where no truth was matched.
  std::vector<Vector6d> error;
  /// `nees` at each state; NaN where there is no error or the covariance is singular.
  std::vector<double> nees_pose, nees_attitude, nees_position;
  /// The reason why no comparison was possible; empty otherwise. With a reason, the alignments are
  /// the identity.
  std::string problem;
};

/// The comparison of eval/ by matched row and by state. It uses the states whose poses are finite.
/// `attitudes`: false for a truth of positions alone; otherwise it is found out.
AgainstTruth against_truth(const Run& run, PoseError nees_coordinates = PoseError::kStandard,
                           bool attitudes = true);

}  // namespace chasles
