#pragma once

#include <vector>

#include <chasles/data/run.hpp>

namespace chasles {

/// The truth brought into the run's world, and what the estimate lacks of it.
struct PoseErrors {
  SE3 world_T_truth_first;  ///< places truth by the first common pose
  SE3 world_T_truth_fit;    ///< places truth by the best rigid fit of the positions
  /// Truth minus estimate at each state, truth placed by the first pose: [theta; dp] with
  /// R_true = Exp(theta) R_hat, as RunState::pose_covariance. NaN where truth says nothing.
  std::vector<Vector6d> error;
  /// error' P^-1 error of the pose and of its halves; NaN where there is no error or P is singular.
  std::vector<double> nees_pose, nees_attitude, nees_position;
};

/// Truth is taken at the times of the states, between two poses along the screw that joins them.
/// Without a common time the errors are all NaN and the placements the identity.
PoseErrors pose_errors(const std::vector<RunState>& states, const Trajectory& truth);

}  // namespace chasles
