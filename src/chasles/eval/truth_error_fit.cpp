#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <chasles/eval/truth_error_model.hpp>

namespace chasles {
namespace {

constexpr double kJitter = 0.001, kTurnJitter = 0.0003;  // of any truth, white [m], [rad]
constexpr int kGaussNewtonSteps = 4;
constexpr std::size_t kScoreBlocks = 20;
constexpr double kMostVariance = 150;  // factor on the covariances

// Residuals and derivatives with unit covariance, row by row.
struct WhiteRows {
  Eigen::VectorXd residual;
  Eigen::Matrix<double, Eigen::Dynamic, 7> jacobian;
  double log_scale = 0;  // of the whitening, without what does not depend on the correlation
};

struct MarkovRows {
  std::vector<double> times;                      // [s]
  std::vector<Eigen::Matrix<double, 6, 8>> rows;  // [jacobian, residual] divided by the sigmas
};

MarkovRows divided_by_sigmas(const TruthErrorModel& model, std::span<const Matrix6d> covariances,
                             const Vector7d& constants) {
  const std::vector<Vector6d> errors = model.errors(constants);
  const std::vector<Matrix67d> jacobians = model.jacobians(constants);
  MarkovRows result;
  for (std::size_t i = 1; i < errors.size(); ++i) {
    const Eigen::LLT<Matrix6d> llt(with_jitter(covariances[i]));
    Eigen::Matrix<double, 6, 8> row;
    row << jacobians[i], errors[i] - jacobians[i] * constants;
    result.times.push_back(
        to_seconds(model.matched.estimate[i].time - model.matched.estimate[0].time));
    result.rows.push_back(llt.matrixL().solve(row));
  }
  return result;
}

WhiteRows whitened(const MarkovRows& process, double correlation) {
  const auto n = static_cast<Eigen::Index>(process.rows.size());
  WhiteRows white{.residual = Eigen::VectorXd(6 * n), .jacobian = {6 * n, 7}};
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    Eigen::Matrix<double, 6, 8> row = process.rows[k];
    if (i > 0) {
      const double alike = std::exp(-(process.times[k] - process.times[k - 1]) / correlation);
      const double rest = std::sqrt(1 - alike * alike);
      row = (row - alike * process.rows[k - 1]) / rest;
      white.log_scale += 6 * std::log(rest);
    }
    white.jacobian.middleRows<6>(6 * i) = row.leftCols<7>();
    white.residual.segment<6>(6 * i) = row.col(7);
  }
  return white;
}

// What the marginal likelihood of a variance factor takes of the rows.
struct MarginalSums {
  Matrix7d H;
  Vector7d g;
  double squares = 0, rows = 0, log_scale = 0;
};

// The logarithm of the likelihood, the constants integrated over their prior, but for a constant.
double log_likelihood(const MarginalSums& sums, const Vector7d& information, double variance) {
  Matrix7d H = sums.H / variance;
  H.diagonal() += information;
  const Eigen::LLT<Matrix7d> llt(H);
  const Vector7d g = sums.g / variance;
  const double log_det = 2 * llt.matrixLLT().diagonal().array().log().sum();
  const double squares = sums.squares / variance - g.dot(llt.solve(g));
  return -0.5 * (sums.rows * std::log(variance) + 2 * sums.log_scale + log_det + squares);
}

// The squares of what leaving out each block in time would change, summed (jackknife): large where
// few moments decide and contradict each other.
Matrix7d jackknife(const WhiteRows& white, const Vector7d& information, const TruthErrorFit& fit) {
  const Eigen::VectorXd left = white.residual + white.jacobian * fit.value;
  const Matrix7d H = fit.covariance.inverse();
  const Eigen::Index rows = left.size() / 6;
  const auto blocks = std::min<Eigen::Index>(kScoreBlocks, rows);
  Matrix7d sum = fit.covariance * information.asDiagonal() * fit.covariance;
  for (Eigen::Index b = 0; b < blocks; ++b) {
    const Eigen::Index begin = 6 * (b * rows / blocks), end = 6 * ((b + 1) * rows / blocks);
    const auto J = white.jacobian.middleRows(begin, end - begin);
    const Vector7d score = J.transpose() * left.segment(begin, end - begin) / fit.variance_factor;
    const Matrix7d without = H - J.transpose() * J / fit.variance_factor;
    const Vector7d change = without.ldlt().solve(score);
    sum += change * change.transpose();
  }
  return sum;
}

void widen(const WhiteRows& white, const Vector7d& information, TruthErrorFit& fit) {
  const Vector7d variances = jackknife(white, information, fit).diagonal();
  const Vector7d wider = (variances.array() / fit.covariance.diagonal().array()).max(1).sqrt();
  fit.robust_covariance = wider.asDiagonal() * fit.covariance * wider.asDiagonal();
}

// The rows are residual + jacobian constants. Takes the process of the largest likelihood.
void choose(const MarkovRows& process, const Vector7d& information, TruthErrorFit& fit,
            WhiteRows& chosen) {
  double best = -std::numeric_limits<double>::infinity();
  MarginalSums of_best;
  for (const double correlation : {0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0}) {
    WhiteRows white = whitened(process, correlation);
    const MarginalSums sums{.H = white.jacobian.transpose() * white.jacobian,
                            .g = -white.jacobian.transpose() * white.residual,
                            .squares = white.residual.squaredNorm(),
                            .rows = static_cast<double>(white.residual.size()),
                            .log_scale = white.log_scale};
    bool better = false;
    for (double variance = 1; variance < kMostVariance; variance *= 1.2) {
      const double likelihood = log_likelihood(sums, information, variance);
      if (likelihood <= best) continue;
      best = likelihood;
      better = true;
      fit.correlation = correlation;
      fit.variance_factor = variance;
    }
    if (!better) continue;
    of_best = sums;
    chosen = std::move(white);
  }
  Matrix7d H = of_best.H / fit.variance_factor;
  H.diagonal() += information;
  fit.covariance = H.inverse();
  fit.value = fit.covariance * of_best.g / fit.variance_factor;
}

}  // namespace

Matrix6d with_jitter(const Matrix6d& P) {
  Matrix6d sum = P;
  sum.diagonal().head<3>().array() += kTurnJitter * kTurnJitter;
  sum.diagonal().tail<3>().array() += kJitter * kJitter;
  return sum;
}

TruthErrorFit fit_truth_errors(const TruthErrorModel& model, std::span<const Matrix6d> covariances,
                               const TruthErrorPriors& priors) {
  Vector7d information = Vector7d::Constant(1 / (priors.rotation * priors.rotation));
  information[0] = 1 / (priors.time * priors.time);
  TruthErrorFit fit;
  WhiteRows white;
  for (int step = 0; step < kGaussNewtonSteps; ++step) {
    choose(divided_by_sigmas(model, covariances, fit.value), information, fit, white);
  }
  widen(white, information, fit);
  return fit;
}

}  // namespace chasles
