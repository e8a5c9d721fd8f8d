#pragma once

#include <string_view>

#include <chasles/eval/association.hpp>

namespace chasles {

/// The transform from the estimate's world to the truth's before the two are compared.
enum class Alignment {
  kNone,         ///< none: both are in the same world already
  kFirstPose,    ///< the first poses coincide
  kFirstLevel,   ///< the positions and headings of the first poses coincide; z is up in both worlds
  kPositionYaw,  ///< least squares over translation and the rotation about the z axis of both
                 ///< worlds
  kRigid,        ///< least squares over SE(3) (Umeyama 1991 without scale)
  kSimilarity,   ///< least squares over Sim(3) (Umeyama 1991)
};

/// "none", "first pose", "first position + yaw", "position + yaw", "SE(3)", "Sim(3)".
std::string_view name(Alignment alignment);

/// p_truth = scale * R * p_estimate + p.
struct WorldAlignment {
  SE3 truth_T_estimate;
  double scale = 1;
  /// Dimension of the set of positions that determines the rotation. 2: fully determined; 1 (a
  /// straight line): the attitudes determine the rotation about the line; 0 (a point): the
  /// attitudes determine all of it.
  int rank = 2;

  /// A pose of the estimate in the truth's world.
  SE3 operator()(const SE3& pose) const;
};

/// The transform of the given kind that minimises the sum of squared position differences.
///
/// Where the positions do not determine it, the attitudes do: of all minimisers the function
/// returns the one with the smallest sum of squared (chordal) attitude differences, and reports
/// `rank`. A single point has scale 1. Positions that are nearly, but not exactly, on a line do
/// determine the rotation. On a straight road the rotation about the direction of travel is then
/// badly determined, and with it the attitude error (docs/evaluation.md).
///
/// kPositionYaw and kFirstLevel presume that the z axes of both worlds are vertical.
WorldAlignment align(const MatchedTrajectories& matched, Alignment alignment);

}  // namespace chasles
