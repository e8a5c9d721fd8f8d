#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/eval/alignment.hpp>
#include <chasles/eval/ate.hpp>
#include <chasles/eval/nees.hpp>
#include <chasles/lie/small_matrices.hpp>

namespace chasles {
namespace {

// `variance(i, axis)`: of the i-th error.
template <class Variance>
SigmaShares shares_of(std::span<const Vector6d> errors, const Variance& variance, double sigmas) {
  SigmaShares result{.sigmas = sigmas};
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    std::size_t inside = 0, count = 0;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const double of_error = variance(i, axis);
      if (!(of_error > 0) || !std::isfinite(of_error)) continue;
      ++count;
      inside += std::abs(errors[i][axis]) <= sigmas * std::sqrt(of_error) ? 1 : 0;
    }
    const auto i = static_cast<std::size_t>(axis);
    result.count[i] = count;
    result.share[i] = count == 0 ? kNaN : static_cast<double>(inside) / static_cast<double>(count);
  }
  return result;
}

}  // namespace

// P is scaled to unit diagonal first, so that "singular" does not depend on the units: a pivot
// below the limit is a correlation of 1 within round-off.
double normalised_square(const Eigen::VectorXd& e, const Eigen::MatrixXd& P) {
  constexpr double kSmallestPivot = 1e-12;
  if (!P.allFinite() || !(P.diagonal().array() > 0).all()) return kNaN;
  const Eigen::VectorXd inverse_sigma = P.diagonal().array().rsqrt();
  const Eigen::LLT<Eigen::MatrixXd> llt(P.cwiseProduct(inverse_sigma * inverse_sigma.transpose()));
  if (llt.info() != Eigen::Success) return kNaN;
  if (llt.matrixLLT().diagonal().array().square().minCoeff() < kSmallestPivot) return kNaN;
  return llt.matrixL().solve(inverse_sigma.cwiseProduct(e)).squaredNorm();
}

std::string_view name(PoseError definition) {
  switch (definition) {
    case PoseError::kStandard:
      return "standard";
    case PoseError::kBodyTwist:
      return "body-twist";
    case PoseError::kWorldTwist:
      return "world-twist";
  }
  return "";
}

Vector6d pose_error(PoseError definition, const SE3& truth, const SE3& estimate) {
  if (definition == PoseError::kBodyTwist) return se3::log(estimate.inverse() * truth);
  if (definition == PoseError::kWorldTwist) return se3::log(truth * estimate.inverse());
  Vector6d error;
  error << so3::log(truth.R * estimate.R.transpose()), truth.p - estimate.p;
  return error;
}

Matrix6d pose_error_map(PoseError definition, const SE3& estimate) {
  Matrix6d M = Matrix6d::Identity();
  if (definition == PoseError::kBodyTwist) {
    M.topLeftCorner<3, 3>() = estimate.R.transpose();
    M.bottomRightCorner<3, 3>() = estimate.R.transpose();
  } else if (definition == PoseError::kWorldTwist) {
    M.bottomLeftCorner<3, 3>() = hat(estimate.p);
  }
  return M;
}

PoseError pose_error_of(std::string_view chart) {
  if (chart == "left-se3") return PoseError::kBodyTwist;
  const bool turns = chart == "right-se3" || chart == "right-sen3";
  return turns ? PoseError::kWorldTwist : PoseError::kStandard;
}

PoseNees pose_nees(PoseError definition, const SE3& truth, const SE3& estimate,
                   const Matrix6d& covariance) {
  const Vector6d e = pose_error(definition, truth, estimate);
  const Matrix6d M = pose_error_map(definition, estimate);
  const Matrix6d P = congruence(M, covariance);
  return {.position = normalised_square(e.tail<3>(), P.bottomRightCorner<3, 3>()),
          .attitude = normalised_square(e.head<3>(), P.topLeftCorner<3, 3>()),
          .pose = normalised_square(e, P)};
}

ConsistencySummary summarize_nees(std::span<const double> values, int dof) {
  ConsistencySummary summary;
  summary.dof = dof;
  std::vector<double> valid;
  std::copy_if(values.begin(), values.end(), std::back_inserter(valid),
               [](double x) { return !std::isnan(x); });
  summary.count = valid.size();
  summary.skipped = values.size() - valid.size();
  const Band one = chi2_band(dof, 1);
  const auto inside =
      std::count_if(valid.begin(), valid.end(), [&](double x) { return one.contains(x); });
  const Statistics all = statistics(std::move(valid));
  summary.mean = all.mean;
  summary.median = all.median;
  summary.inside =
      all.count == 0 ? kNaN : static_cast<double>(inside) / static_cast<double>(all.count);
  if (all.count > 0) summary.band = chi2_band(dof, all.count);
  return summary;
}

SigmaShares sigma_shares(std::span<const Vector6d> errors, std::span<const Matrix6d> covariances,
                         double sigmas) {
  return shares_of(
      errors, [&](std::size_t i, Eigen::Index axis) { return covariances[i](axis, axis); }, sigmas);
}

Nees nees_of_truths(const MatchedTrajectories& matched, std::span<const SE3> truths,
                    std::span<const Matrix6d> covariances, PoseError definition) {
  constexpr double kSigmas = 3;
  Nees result;
  result.definition = definition;
  if (truths.empty()) return result;
  std::vector<Vector6d> errors;
  errors.reserve(truths.size());
  for (std::size_t i = 0; i < truths.size(); ++i) {
    const std::size_t row = matched.estimate_index[i];
    if (row >= covariances.size()) {
      throw InputError(fmt::format(
          "NEES: {} covariances, but pose {} of the estimate needs one; expected one a pose",
          covariances.size(), row));
    }
    const SE3& estimate = matched.estimate[i].pose;
    const PoseNees one = pose_nees(definition, truths[i], estimate, covariances[row]);
    errors.push_back(pose_error(PoseError::kStandard, truths[i], estimate));
    result.times.push_back(matched.estimate[i].time);
    result.attitude.push_back(one.attitude);
    result.position.push_back(one.position);
    result.pose.push_back(one.pose);
  }
  result.attitude_summary = summarize_nees(result.attitude, 3);
  result.position_summary = summarize_nees(result.position, 3);
  result.pose_summary = summarize_nees(result.pose, 6);
  result.within_3_sigma = shares_of(
      errors,
      [&](std::size_t i, Eigen::Index axis) {
        return covariances[matched.estimate_index[i]](axis, axis);
      },
      kSigmas);
  return result;
}

Nees nees(const MatchedTrajectories& matched, std::span<const Matrix6d> covariances,
          PoseError definition, bool level) {
  std::vector<SE3> truths;
  if (!matched.truth.empty()) {
    const SE3 estimate_T_truth =
        align(matched, level ? Alignment::kFirstLevel : Alignment::kFirstPose)
            .truth_T_estimate.inverse();
    truths.reserve(matched.truth.size());
    for (const StampedPose& row : matched.truth) truths.push_back(estimate_T_truth * row.pose);
  }
  return nees_of_truths(matched, truths, covariances, definition);
}

}  // namespace chasles
