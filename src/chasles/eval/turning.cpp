#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <chasles/base/median.hpp>
#include <chasles/eval/association.hpp>
#include <chasles/eval/turning.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

constexpr std::size_t kFewestWindows = 20;
constexpr std::size_t kBlocks = 20;
constexpr double kLongestStep = 0.2;  // of the offset in one iteration [s]

// A window of the reference, and the truth's rate there with its slope.
struct RatePair {
  Eigen::Vector3d reference, truth;
  Eigen::Vector3d slope;  // of the truth's rate [rad/s^2]
};

Time shifted(Time time, double offset) { return time - from_seconds(offset); }

std::vector<RatePair> pairs_of(const std::vector<RateWindow>& reference, const Trajectory& truth,
                               double offset, Time gap, bool slopes) {
  const Time spacing = median_spacing(truth);
  const Time d = std::clamp(spacing, Time(std::chrono::milliseconds(10)), gap) / 2;
  std::vector<RatePair> pairs;
  for (const RateWindow& w : reference) {
    const Time begin = shifted(w.begin, offset), end = shifted(w.end, offset);
    const auto rate = mean_rate(truth, begin, end, gap);
    if (!rate) continue;
    pairs.push_back({w.rate, *rate, Eigen::Vector3d::Zero()});
    if (!slopes) continue;
    const auto before = mean_rate(truth, begin - d, end - d, gap);
    const auto after = mean_rate(truth, begin + d, end + d, gap);
    if (before && after) pairs.back().slope = (*after - *before) / (2 * to_seconds(d));
  }
  return pairs;
}

// The rotation that maps the truth's rates best to the reference's; near the identity where they do
// not determine it.
Eigen::Matrix3d first_rotation(const std::vector<RatePair>& pairs, bool biased) {
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero(), mean_b = Eigen::Vector3d::Zero();
  const auto n = static_cast<double>(pairs.size());
  for (const RatePair& pair : pairs) {
    mean_a += biased ? Eigen::Vector3d(pair.reference / n) : Eigen::Vector3d::Zero();
    mean_b += biased ? Eigen::Vector3d(pair.truth / n) : Eigen::Vector3d::Zero();
  }
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const RatePair& pair : pairs) {
    sum += (pair.reference - mean_a) * (pair.truth - mean_b).transpose();
  }
  sum += 1e-3 * sum.norm() * Eigen::Matrix3d::Identity();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

Eigen::Vector3d residual_of(const RatePair& pair, const TurningFit& fit) {
  return pair.reference - fit.reference_R_truth * pair.truth - fit.bias;
}

// Root mean square of the smaller 90 %.
double trimmed(std::vector<double> squares) {
  const auto kept = static_cast<std::ptrdiff_t>((9 * squares.size() + 9) / 10);
  std::nth_element(squares.begin(), squares.begin() + kept - 1, squares.end());
  double sum = 0;
  for (auto s = squares.begin(); s != squares.begin() + kept; ++s) sum += *s;
  return std::sqrt(sum / static_cast<double>(kept));
}

double trimmed_residual(const std::vector<RatePair>& pairs, const TurningFit& fit) {
  std::vector<double> squares;
  for (const RatePair& pair : pairs) squares.push_back(residual_of(pair, fit).squaredNorm());
  return trimmed(std::move(squares));
}

Eigen::Vector3d median_residual(const std::vector<RatePair>& pairs, const TurningFit& fit) {
  Eigen::Vector3d middle;
  std::vector<double> values(pairs.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(pairs, values.begin(),
                           [&](const RatePair& p) { return residual_of(p, fit)[axis]; });
    middle[axis] = median(values);
  }
  return middle;
}

// Normal equations of one iteration, in units of the residuals' variance. A weak prior holds what
// the motion does not determine.
struct Normal {
  Matrix7 H = Matrix7::Zero(), scores = Matrix7::Zero();
  Vector7 g = Vector7::Zero();
};

Normal normal_equations(const std::vector<RatePair>& pairs, const TurningFit& fit, bool biased) {
  std::vector<double> norms;
  for (const RatePair& pair : pairs) norms.push_back(residual_of(pair, fit).norm());
  const double scale = std::max(median(norms), 1e-9);
  const double variance =
      scale * scale / 2.366;  // the median of chi-square with 3 degrees is 2.366
  Normal normal;
  Vector7 prior = Vector7::Ones();  // of 1 rad, 1 rad/s (or none free), 1 s
  if (!biased) prior.segment<3>(3).setConstant(1e18);
  normal.H.diagonal() = prior;
  normal.scores.diagonal() = Vector7::Ones();
  if (!biased) normal.scores.diagonal().segment<3>(3).setZero();
  Vector7 block = Vector7::Zero();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector3d r = residual_of(pairs[i], fit);
    const double w = 1 / (1 + r.squaredNorm() / (9 * scale * scale)) / variance;
    Eigen::Matrix<double, 3, 7> J;
    J.leftCols<3>() = -hat(fit.reference_R_truth * pairs[i].truth);
    J.middleCols<3>(3).setIdentity();
    if (!biased) J.middleCols<3>(3).setZero();
    J.col(6) = -(fit.reference_R_truth * pairs[i].slope);
    normal.H += w * J.transpose() * J;
    normal.g += w * J.transpose() * r;
    block += w * J.transpose() * r;
    const bool last = (i + 1) * kBlocks / pairs.size() != i * kBlocks / pairs.size();
    if (!last) continue;
    normal.scores += block * block.transpose();
    block.setZero();
  }
  return normal;
}

void take_step(const Normal& normal, TurningFit& fit) {
  const Vector7 d = normal.H.ldlt().solve(normal.g);
  fit.reference_R_truth = so3::exp(d.head<3>()) * fit.reference_R_truth;
  fit.bias += d.segment<3>(3);
  fit.offset += std::clamp(d[6], -kLongestStep, kLongestStep);
}

void add_sigmas(const Normal& normal, TurningFit& fit) {
  const Matrix7 inverse = normal.H.inverse();
  const Matrix7 covariance = inverse * normal.scores * inverse;
  fit.offset_sigma = std::sqrt(covariance(6, 6));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance.topLeftCorner<3, 3>());
  fit.rotation_sigma = std::sqrt(std::max(0.0, axes.eigenvalues()[2]));
}

}  // namespace

std::optional<Eigen::Vector3d> mean_rate(const Trajectory& poses, Time begin, Time end, Time gap) {
  const auto a = pose_at(poses, begin, gap), b = pose_at(poses, end, gap);
  if (!a || !b) return std::nullopt;
  return so3::log(a->R.transpose() * b->R) / to_seconds(end - begin);
}

std::vector<RateWindow> rate_windows(const Trajectory& poses, Time length, std::size_t most) {
  std::vector<RateWindow> windows;
  for (std::size_t a = 0, b = 0; a < poses.size(); a = b) {
    while (b < poses.size() && poses[b].time < poses[a].time + length) ++b;
    if (b == poses.size()) break;
    const Time span = poses[b].time - poses[a].time;
    if (span > 2 * length) continue;
    windows.push_back({poses[a].time, poses[b].time,
                       so3::log(poses[a].pose.R.transpose() * poses[b].pose.R) / to_seconds(span)});
  }
  const std::size_t every = (windows.size() + most - 1) / most;
  std::vector<RateWindow> kept;
  for (std::size_t i = 0; i < windows.size(); i += std::max<std::size_t>(every, 1)) {
    kept.push_back(windows[i]);
  }
  return kept;
}

std::optional<TurningFit> fit_turning(const std::vector<RateWindow>& reference,
                                      const Trajectory& truth, double start_offset,
                                      const TurningOptions& options) {
  TurningFit fit{.offset = start_offset};
  std::vector<RatePair> pairs = pairs_of(reference, truth, fit.offset, options.gap, true);
  if (pairs.size() < kFewestWindows) return std::nullopt;
  fit.reference_R_truth = first_rotation(pairs, options.biased);
  if (options.biased) fit.bias = median_residual(pairs, fit);
  for (int iteration = 0; iteration < 8; ++iteration) {
    take_step(normal_equations(pairs, fit, options.biased), fit);
    if (!(std::abs(fit.offset) < 1e10)) return std::nullopt;
    pairs = pairs_of(reference, truth, fit.offset, options.gap, true);
    if (pairs.size() < kFewestWindows) return std::nullopt;
  }
  add_sigmas(normal_equations(pairs, fit, options.biased), fit);
  fit.windows = pairs.size();
  fit.residual = trimmed_residual(pairs, fit);
  std::vector<double> squares;
  for (const RatePair& pair : pairs) squares.push_back((pair.reference - fit.bias).squaredNorm());
  fit.signal = trimmed(std::move(squares));
  return fit;
}

double turning_residual(const std::vector<RateWindow>& reference, const Trajectory& truth,
                        double offset, const Eigen::Matrix3d& reference_R_truth,
                        const TurningOptions& options) {
  const std::vector<RatePair> pairs = pairs_of(reference, truth, offset, options.gap, false);
  TurningFit fit{.reference_R_truth = reference_R_truth};
  if (pairs.empty()) return std::numeric_limits<double>::infinity();
  if (options.biased) fit.bias = median_residual(pairs, fit);
  return trimmed_residual(pairs, fit);
}

}  // namespace chasles
