#pragma once

#include <cstddef>
#include <vector>

#include <chasles/eval/association.hpp>
#include <chasles/eval/nees.hpp>

namespace chasles {

/// An estimate of world_T_imu with the covariance of each pose: 6x6, of the standard error [theta;
/// dp] in the axes of its world [rad, m].
struct EstimatedPath {
  Trajectory poses;
  std::vector<Matrix6d> covariances;  ///< one for each pose
};

/// The difference of two estimates of one motion, and whether their covariances explain it
/// (docs/evaluation.md). No truth is needed.
struct PairDifference {
  std::size_t compared = 0;                         ///< poses of the first estimate
  double duration_s = 0;                            ///< from the first to the last of them
  double position_rms_m = 0, attitude_rms_deg = 0;  ///< of the difference
  /// d^T (P_a + P_b)^-1 d of the difference d: a mean of at most dof if both covariances hold.
  ConsistencySummary position, attitude, pose;
  SigmaShares within_3_sigma;

  /// Root of the mean over its dof, of the pose: the sigmas are too small by this factor at least,
  /// where it is above 1 by more than chance (kMostByChance).
  double factor() const;
};

/// PairDifference::factor() above which a pair is overconfident. None of 179 consistent pairs was
/// above it (studies/evaluation.md).
inline constexpr double kMostByChance = 1.5;

/// Compares the first estimate with the second one at its times, after the first common pose of
/// both is aligned; `level`: by position and heading alone, because the z axes of both worlds point
/// up.
///
/// Errors that both estimates share, as those of the same IMU samples, are not in the difference.
/// If the estimates share no measurement of points, their errors correlate positively by what they
/// share, and P_a + P_b is an upper bound of the difference's covariance.
///
/// Throws InputError as associate(), for covariances whose number is not that of the poses or that
/// are mostly singular, and for estimates that are equal.
PairDifference pair_difference(const EstimatedPath& a, const EstimatedPath& b, bool level);

}  // namespace chasles
