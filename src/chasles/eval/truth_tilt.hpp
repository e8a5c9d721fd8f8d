#pragma once

#include <chasles/eval/association.hpp>

// Truths whose world is not level, as those relative to their own first pose.
namespace chasles {

/// Whether the first pose is the identity to within the rounding of a file: 1 um and 1 urad. This
/// is what a truth relative to its first pose looks like. Its z axis is that of the body at that
/// time, not the vertical. False without poses.
bool begins_at_identity(const Trajectory& truth);

/// A rotation of the truth's world about a horizontal axis.
struct TruthTilt {
  Eigen::Matrix3d level_R_truth = Eigen::Matrix3d::Identity();
  double degrees = 0;  ///< its angle, from 0 to 180
};

/// The tilt of the truth's world against the estimate's, whose z axis is vertical.
///
/// The attitudes determine it: the rotation truth_R_estimate with the smallest sum of squared
/// (chordal) attitude differences is a turn about the vertical after a tilt. Positions would
/// determine the tilt about the direction of travel badly on a straight path. The mean tilt error
/// of the estimate becomes part of the result. Without pairs: no tilt.
TruthTilt truth_tilt(const MatchedTrajectories& matched);

/// Turns the truth's world by that tilt, about its origin: its z axis becomes vertical. Heading and
/// origin stay. Throws InputError as associate().
TruthTilt turn_to_level(Trajectory& truth, const Trajectory& estimate,
                        const TruthPairing& pairing = {});

}  // namespace chasles
