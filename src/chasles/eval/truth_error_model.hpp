#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include <chasles/eval/truth_errors.hpp>

// The parts of estimate_truth_errors().
namespace chasles {

using Matrix67d = Eigen::Matrix<double, 6, 7>;

/// An estimate and its truth with given constants.
struct TruthErrorModel {
  MatchedTrajectories matched;
  const Trajectory& truth;  ///< all of it
  Time gap{};
  bool level = false;

  /// The truth at the matched stamps, without these errors, in its own world. Where the shifted
  /// time is beyond its end, the position goes on at the speed there.
  Trajectory corrected(const Vector7d& constants) const;

  /// estimate_T_truth of nees(), for a corrected truth.
  SE3 first_alignment(const Trajectory& corrected) const;

  /// The standard errors [Log(R R_hat^T); p - p_hat] after that alignment, in the estimate's world.
  std::vector<Vector6d> errors(const Vector7d& constants) const;

  /// Their derivatives by the constants (central differences).
  std::vector<Matrix67d> jacobians(const Vector7d& constants) const;
};

/// A covariance with the white jitter that any truth has; regular also where P is singular.
Matrix6d with_jitter(const Matrix6d& P);

struct TruthErrorFit {
  Vector7d value = Vector7d::Zero();
  Matrix7d covariance;         ///< of the model
  Matrix7d robust_covariance;  ///< where the blocks demand it, larger
  double variance_factor = 1;  ///< on the covariances of the estimate
  double correlation = 0;      ///< [s]
};

/// Fits the constants to the rows of the model, of which the first is the one that is aligned and
/// counts no further. `covariances`: one for each row.
TruthErrorFit fit_truth_errors(const TruthErrorModel& model, std::span<const Matrix6d> covariances,
                               const TruthErrorPriors& priors);

/// The NEES of the model's rows with the constants removed: the errors have the covariance
/// P + A C A^T, A their derivatives and C the constants' covariance. The constants are fitted to
/// the same errors, which takes a part of their squares: the values are divided by the expected
/// rest. Fills `nees` and `fitted_share`. `covariances`: one for each pose of the estimate.
void add_nees(const TruthErrorModel& model, std::span<const Matrix6d> covariances,
              PoseError definition, const TruthErrorFit& fit, TruthErrors& result);

}  // namespace chasles
