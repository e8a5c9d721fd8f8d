#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include <chasles/eval/association.hpp>
#include <chasles/eval/chi2.hpp>

namespace chasles {

/// e^T P^-1 e of an error and its covariance; NaN where P is singular or not finite.
double normalised_square(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance);

/// The coordinates of a pose error. X is the truth, Xhat the estimate; all are [rotation;
/// translation] (docs/derivations.md, D9 to D11).
enum class PoseError {
  kStandard,    ///< [Log(R Rhat^T); p - phat], world axes
  kBodyTwist,   ///< Log(Xhat^-1 X), body axes at the estimate
  kWorldTwist,  ///< Log(X Xhat^-1), world axes about the world's origin
};

/// "standard", "body-twist", "world-twist".
std::string_view name(PoseError definition);

/// The coordinates in which the filter's chart of that name (filter/charts/error_chart.hpp)
/// represents its error; kStandard for one that is not of the library.
PoseError pose_error_of(std::string_view chart);

/// The error in these coordinates.
Vector6d pose_error(PoseError definition, const SE3& truth, const SE3& estimate);

/// d(error in these coordinates) / d(standard error) at a zero error (docs/derivations.md, D14).
/// With it as M, M P M^T transforms a covariance of [theta; dp] to these coordinates.
Matrix6d pose_error_map(PoseError definition, const SE3& estimate);

/// e^T P^-1 e of a pose; NaN where P is singular.
struct PoseNees {
  double position = 0, attitude = 0, pose = 0;
};

/// `covariance` is that of the standard error [theta; dp], world axes [rad, m].
PoseNees pose_nees(PoseError definition, const SE3& truth, const SE3& estimate,
                   const Matrix6d& covariance);

/// A list of chi-square variables.
struct ConsistencySummary {
  int dof = 0;
  std::size_t count = 0;    ///< values
  std::size_t skipped = 0;  ///< stamps whose covariance is singular or not finite
  double mean = 0;          ///< dof for a consistent filter; NaN without values
  double median = 0;
  double inside = 0;  ///< fraction within the two-sided 95 % interval of one variable
  Band band;          ///< 95 % band of the mean for independent values
};

/// NaN entries count as skipped.
ConsistencySummary summarize_nees(std::span<const double> values, int dof);

/// The shares of errors within `sigmas` of their own standard deviations, component by component of
/// the standard pose error [rotation x, y, z; position x, y, z], world axes.
struct SigmaShares {
  double sigmas = 3;
  std::array<std::size_t, 6> count{};  ///< errors whose sigma is positive and finite
  /// Expected with 3 sigmas: 0.9973, of Gaussian errors. NaN without errors.
  std::array<double, 6> share{};
};

/// `errors[i]` has the covariance `covariances[i]`, both of the same length and in the same
/// coordinates. An error whose variance is zero, negative or not finite does not count.
SigmaShares sigma_shares(std::span<const Vector6d> errors, std::span<const Matrix6d> covariances,
                         double sigmas = 3);

/// Normalised estimation error squared, e^T P^-1 e, at each matched stamp; NaN where P is singular.
struct Nees {
  PoseError definition = PoseError::kStandard;
  std::vector<Time> times;
  std::vector<double> position, attitude, pose;
  ConsistencySummary position_summary, attitude_summary, pose_summary;
  SigmaShares within_3_sigma;  ///< of the standard error, whatever `definition` is
};

/// `truths[i]` is the true pose of the matched row i in the estimate's world. `covariances[i]`
/// belongs to row i of the whole estimate (matched.estimate_index refers to it): 6x6, of the
/// standard error [theta; dp] in the axes of the estimate's world [rad, m]. Throws InputError where
/// a matched row has no covariance.
Nees nees_of_truths(const MatchedTrajectories& matched, std::span<const SE3> truths,
                    std::span<const Matrix6d> covariances, PoseError definition);

/// nees_of_truths() with the truth aligned by the first matched pose alone.
///
/// The covariance of a filter that starts from a given pose describes errors relative to that pose;
/// a fit would hide them. `level`: only position and heading of that pose are aligned, because the
/// z axes of both worlds point up. An inertial filter estimates its tilt from gravity, so its tilt
/// error counts from the first pose on.
Nees nees(const MatchedTrajectories& matched, std::span<const Matrix6d> covariances,
          PoseError definition = PoseError::kStandard, bool level = false);

}  // namespace chasles
