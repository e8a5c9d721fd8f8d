#pragma once

#include <string>
#include <vector>

#include <chasles/data/run.hpp>
#include <chasles/eval/nees.hpp>

namespace chasles {

/// The truth brought into the run's world, and what the estimate lacks of it.
struct AgainstTruth {
  SE3 world_T_truth_first;  ///< places truth by the first matched pose, as nees() does
  SE3 world_T_truth_fit;    ///< places truth by the best rigid fit, as the ATE does
  /// Truth minus estimate at each state, truth placed by the first pose: [theta; dp] as
  /// RunState::pose_covariance, [rad, m]. NaN where no truth was matched.
  std::vector<Vector6d> error;
  /// At each state, in the coordinates asked for; NaN where there is no error or the covariance is
  /// singular.
  std::vector<double> nees_pose, nees_attitude, nees_position;
  /// Why nothing could be compared; empty when it could. Then the placements are the identity.
  std::string problem;
};

/// The comparison of eval/ laid out by state.
AgainstTruth against_truth(const Run& run, PoseError nees_coordinates = PoseError::kStandard);

}  // namespace chasles
