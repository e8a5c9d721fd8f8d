#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/truth_error_model.hpp>

namespace chasles {
namespace {

constexpr double kSpacing = 0.25;  // of the poses that are compared [s]
constexpr std::size_t kFewestRows = 20, kMostRows = 3000;
constexpr double kSignificant = 3;                  // sigmas
constexpr double kSignificantProbability = 0.9973;  // of as many in one dimension
// Of the calibration that the estimate relies on [s], [rad].
constexpr double kCalibrationTime = 0.0005, kCalibrationTurn = 0.15 * kRadians;

bool is_regular(const Matrix6d& P) {
  return P.allFinite() && P.diagonal().maxCoeff() > 0 &&
         Eigen::LLT<Matrix6d>(with_jitter(P)).info() == Eigen::Success;
}

// The first row, and of the others with a covariance those that are far enough apart.
std::vector<std::size_t> compared_rows(const MatchedTrajectories& matched,
                                       std::span<const Matrix6d> covariances) {
  const double span = to_seconds(matched.estimate.back().time - matched.estimate.front().time);
  const Time spacing = from_seconds(std::max(kSpacing, span / kMostRows));
  constexpr Time kRounding = std::chrono::milliseconds(1);
  std::vector<std::size_t> rows{0};
  for (std::size_t i = 1; i < matched.estimate.size(); ++i) {
    const Time since = matched.estimate[i].time - matched.estimate[rows.back()].time;
    if (since + kRounding < spacing || !is_regular(covariances[matched.estimate_index[i]])) {
      continue;
    }
    rows.push_back(i);
  }
  if (rows.size() > kFewestRows) return rows;
  throw InputError(fmt::format(
      "truth errors: found {} poses with a truth and a covariance that is not zero, {:g} s apart; "
      "expected at least {}",
      rows.size() - 1, kSpacing, kFewestRows));
}

TruthErrorModel thinned(const TruthErrorModel& model, const std::vector<std::size_t>& rows) {
  TruthErrorModel result{
      .matched = {}, .truth = model.truth, .gap = model.gap, .level = model.level};
  for (const std::size_t row : rows) {
    result.matched.estimate.push_back(model.matched.estimate[row]);
    result.matched.truth.push_back(model.matched.truth[row]);
    result.matched.estimate_index.push_back(model.matched.estimate_index[row]);
  }
  return result;
}

// d(heading of the first true attitude) / d(constants).
Vector7d heading_of_first(const TruthErrorModel& model, const Vector7d& constants) {
  Vector7d derivative = Vector7d::Zero();
  const Eigen::Matrix3d R = model.corrected(constants).front().pose.R;
  derivative.segment<3>(1) = R.row(2).transpose();
  derivative.tail<3>() = Eigen::Vector3d::UnitZ();
  return derivative;
}

}  // namespace

double TruthErrors::sigma(Eigen::Index i) const { return std::sqrt(covariance(i, i)); }

bool TruthErrors::significant(TruthErrorKind kind) const {
  if (kind == TruthErrorKind::kPositionTime) {
    return std::abs(value[0]) > kSignificant * std::hypot(sigma(0), kCalibrationTime);
  }
  const Eigen::Index first = kind == TruthErrorKind::kBodyRotation ? 1 : 4;
  Eigen::Matrix3d wider = covariance.block<3, 3>(first, first);
  wider.diagonal().array() += kCalibrationTurn * kCalibrationTurn;
  const double square = normalised_square(value.segment<3>(first), wider);
  return square > chi2_quantile(kSignificantProbability, 3);
}

bool TruthErrors::first_heading_significant() const {
  return std::abs(first_heading) > kSignificant * std::hypot(first_heading_sigma, kCalibrationTurn);
}

TruthErrors estimate_truth_errors(const Trajectory& estimate, const Trajectory& truth,
                                  std::span<const Matrix6d> covariances,
                                  const TruthErrorOptions& options) {
  if (covariances.size() != estimate.size()) {
    throw InputError(fmt::format(
        "truth errors: {} covariances for {} poses of the estimate, expected one a pose",
        covariances.size(), estimate.size()));
  }
  const TruthErrorModel model{.matched = associate(estimate, truth, options.pairing),
                              .truth = truth,
                              .gap = options.pairing.longest_gap,
                              .level = options.level};
  const std::vector<std::size_t> rows = compared_rows(model.matched, covariances);
  std::vector<Matrix6d> of_rows;
  for (const std::size_t row : rows)
    of_rows.push_back(covariances[model.matched.estimate_index[row]]);
  const TruthErrorFit fit = fit_truth_errors(thinned(model, rows), of_rows, options.priors);
  TruthErrors result{.value = fit.value,
                     .covariance = fit.robust_covariance,
                     .sigma_factor = std::sqrt(fit.variance_factor),
                     .correlation = fit.correlation,
                     .nees = {},
                     .rigid = {}};
  const Vector7d heading = heading_of_first(model, fit.value);
  result.first_heading = heading.dot(fit.value);
  result.first_heading_sigma = std::sqrt(heading.dot(fit.robust_covariance * heading));
  add_nees(model, covariances, options.pose_error, fit, result);
  MatchedTrajectories corrected = model.matched;
  corrected.truth = model.corrected(fit.value);
  result.rigid = absolute_error(corrected, Alignment::kRigid);
  return result;
}

}  // namespace chasles
