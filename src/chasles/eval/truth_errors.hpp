#pragma once

#include <array>
#include <optional>
#include <span>

#include <Eigen/Core>

#include <chasles/base/constants.hpp>
#include <chasles/eval/ate.hpp>
#include <chasles/eval/nees.hpp>

// Constant errors of a truth, estimated together from an estimate and the truth
// (docs/evaluation.md).
namespace chasles {

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

/// The constants of a truth: [position time; body rotation; world rotation] [s, rad, rad]. The true
/// pose at the stamp t is
///     R = Exp(world) R_file(t) Exp(body),    p = p_file(t + time)
/// so that positions which are stamped late have a positive time. `world` turns the attitudes
/// against the positions. The heading and the position of the truth's world are no errors.
struct TruthConstants {
  double position_time = 0;
  Eigen::Vector3d body = Eigen::Vector3d::Zero(), world = Eigen::Vector3d::Zero();

  static TruthConstants from(const Vector7d& vector);
};

/// Standard deviations of the constants before the comparison. They are the sizes that the truth of
/// EuRoC's Machine Hall has (studies/evaluation.md).
struct TruthErrorPriors {
  double time = 0.010;               ///< [s]
  double rotation = 1.5 * kRadians;  ///< about each axis, of body and world [rad]
};

struct TruthErrorOptions {
  TruthPairing pairing;
  PoseError pose_error = PoseError::kStandard;
  bool level = false;  ///< z points up in the estimate's world: as in nees()
  TruthErrorPriors priors;
};

/// A constant with three axes, or one.
enum class TruthErrorKind { kPositionTime, kBodyRotation, kWorldRotation };

/// What was found, and the figures without these errors.
struct TruthErrors {
  Vector7d value = Vector7d::Zero();  ///< as TruthConstants
  Matrix7d covariance = Matrix7d::Zero();
  /// Heading error of the first pose, by which NEES turns the truth [rad], and its sigma.
  double first_heading = 0, first_heading_sigma = 0;
  double sigma_factor = 1;  ///< on the estimate's sigmas, by which its errors are explained
  double correlation = 0;   ///< time in which the estimate's errors decorrelate [s]
  Nees nees;                ///< with the constants removed, and marginalised
  /// The part of the degrees of freedom that the constants took, of position, attitude and pose.
  std::array<double, 3> fitted_share{};
  AbsoluteError rigid;  ///< after SE(3) alignment, with the constants removed

  double sigma(Eigen::Index i) const;
  /// Whether the constant differs from zero by 3 sigmas, or as improbably in three axes. The sigmas
  /// have 0.5 ms and 0.15 deg added, which the calibration of the cameras may be off.
  bool significant(TruthErrorKind kind) const;
  bool first_heading_significant() const;
};

/// Estimates the constants by least squares with their priors. The errors of the estimate have its
/// covariances and are correlated in time: divided by their sigmas, with the attitude's part taken
/// out of the position's, they are a first-order Markov process. Its correlation time, and a factor
/// of at least 1 on the covariances, have the largest marginal likelihood. A jackknife over 20
/// blocks in time widens a sigma where this process does not explain the residuals.
///
/// `covariances`: as nees() takes them. Throws InputError as associate(), for covariances whose
/// number is not that of the poses, and where fewer than 5 s of poses have a covariance that is not
/// singular. The truth must have attitudes.
TruthErrors estimate_truth_errors(const Trajectory& estimate, const Trajectory& truth,
                                  std::span<const Matrix6d> covariances,
                                  const TruthErrorOptions& options = {});

}  // namespace chasles
