#pragma once

#include <string_view>

#include <chasles/eval/association.hpp>

namespace chasles {

/// How the estimate's world is brought to the truth's before the two are compared.
enum class Alignment {
  kNone,         ///< not at all: both are in the same world already
  kFirstPose,    ///< the first poses coincide
  kFirstLevel,   ///< positions and headings of the first poses do; z is up in both worlds
  kPositionYaw,  ///< least squares over translation and the turn about the z axis of both worlds
  kRigid,        ///< least squares over SE(3) (Umeyama 1991 without scale)
  kSimilarity,   ///< least squares over Sim(3) (Umeyama 1991)
};

/// "none", "first pose", "first position + yaw", "position + yaw", "SE(3)", "Sim(3)".
std::string_view name(Alignment alignment);

/// p_truth = scale * R * p_estimate + p.
struct WorldAlignment {
  SE3 truth_T_estimate;
  double scale = 1;
  /// Dimension of the set that the positions determine the rotation from: 2 decides it; 1 (a
  /// straight line) leaves the turn about the line, 0 (a point) everything to the attitudes.
  int rank = 2;

  /// A pose of the estimate in the truth's world.
  SE3 operator()(const SE3& pose) const;
};

/// The transform of the asked kind that minimises the sum of squared position differences.
///
/// What the positions leave open is decided by the attitudes: of all minimisers the one with the
/// smallest sum of squared (chordal) attitude differences is returned, and `rank` tells. A single
/// point has scale 1. Positions that are nearly, not exactly, on a line do determine the rotation
/// and are taken at their word: on a straight drive the turn about the direction of travel is then
/// badly determined, and with it the attitude error (docs/evaluation.md).
/// kPositionYaw and kFirstLevel presume that the z axes of both worlds are vertical.
WorldAlignment align(const MatchedTrajectories& matched, Alignment alignment);

}  // namespace chasles
