#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <chasles/eval/alignment.hpp>
#include <chasles/eval/position_fit.hpp>

namespace chasles {
namespace {

using Vector11 = Eigen::Matrix<double, 11, 1>;  // rotation, translation, log scale, offset, point
using Matrix11 = Eigen::Matrix<double, 11, 11>;

constexpr std::size_t kFewestPositions = 10, kMostPositions = 3000;
constexpr std::size_t kPositionBlocks = 10;

struct PositionPair {
  SE3 estimate;
  Eigen::Vector3d truth, velocity;  // of the truth
};

std::vector<PositionPair> position_pairs(const Trajectory& estimate, const Trajectory& truth,
                                         double offset, Time gap) {
  constexpr Time kSlope = std::chrono::milliseconds(10);
  const std::size_t every = estimate.size() / kMostPositions + 1;
  std::vector<PositionPair> pairs;
  for (std::size_t i = 0; i < estimate.size(); i += every) {
    const Time time = estimate[i].time - from_seconds(offset);
    const auto now = pose_at(truth, time, gap);
    const auto before = pose_at(truth, time - kSlope, gap),
               after = pose_at(truth, time + kSlope, gap);
    if (!now) continue;
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    if (before && after) velocity = (after->p - before->p) / (2 * to_seconds(kSlope));
    pairs.push_back({estimate[i].pose, now->p, velocity});
  }
  return pairs;
}

MatchedTrajectories matched_of(const std::vector<PositionPair>& pairs) {
  MatchedTrajectories matched;
  for (const PositionPair& pair : pairs) {
    matched.estimate.push_back({.time = {}, .pose = pair.estimate});
    matched.truth.push_back({.time = {}, .pose = {Eigen::Matrix3d::Identity(), pair.truth}});
  }
  return matched;
}

Eigen::Vector3d left(const PositionPair& pair, const PositionFit& fit) {
  return pair.truth - fit.truth_T_estimate.p -
         fit.scale * (fit.truth_T_estimate.R * (pair.estimate * fit.point));
}

double rms_of(const std::vector<PositionPair>& pairs, const PositionFit& fit) {
  double sum = 0;
  for (const PositionPair& pair : pairs) sum += left(pair, fit).squaredNorm();
  return std::sqrt(sum / static_cast<double>(pairs.size()));
}

double rms_speed(const std::vector<PositionPair>& pairs) {
  double sum = 0;
  for (const PositionPair& pair : pairs) sum += pair.velocity.squaredNorm();
  return std::sqrt(sum / static_cast<double>(pairs.size()));
}

// What is left after the best rotation and after the best reflection, from the singular values of
// the covariance (Umeyama 1991), each with its best scale.
void add_shape(const std::vector<PositionPair>& pairs, PositionFit& fit) {
  const auto n = static_cast<double>(pairs.size());
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero(), mean_b = Eigen::Vector3d::Zero();
  for (const PositionPair& pair : pairs) {
    mean_a += pair.estimate.p / n;
    mean_b += pair.truth / n;
  }
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero(), own = Eigen::Matrix3d::Zero();
  double spread = 0;
  for (const PositionPair& pair : pairs) {
    const Eigen::Vector3d a = pair.estimate.p - mean_a, b = pair.truth - mean_b;
    cross += b * a.transpose() / n;
    own += b * b.transpose() / n;
    spread += a.squaredNorm() / n;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(own);
  fit.extent = std::sqrt(own.trace());
  fit.breadth = std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
  fit.axis = axes.eigenvectors().col(2);
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double gain = svd.singularValues().sum();
  const double best = spread > 0 ? gain * gain / spread : 0;
  fit.mirrored_rms = fit.rms;
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) {
    fit.mirrored_rms = std::sqrt(std::max(0.0, own.trace() - best));
  }
}

struct PositionNormal {
  Matrix11 H = Matrix11::Identity() * 1e-12, scores = Matrix11::Zero();
  Vector11 g = Vector11::Zero();
};

Eigen::Matrix<double, 3, 11> jacobian(const PositionPair& pair, const PositionFit& fit,
                                      const PositionFitOptions& options) {
  Eigen::Matrix<double, 3, 11> J = Eigen::Matrix<double, 3, 11>::Zero();
  const Eigen::Matrix3d& R = fit.truth_T_estimate.R;
  const Eigen::Vector3d turned = fit.scale * (R * (pair.estimate * fit.point));
  J.leftCols<3>() = -hat(turned);
  J.middleCols<3>(3).setIdentity();
  if (options.scale) J.col(6) = turned;
  if (options.offset) J.col(7) = pair.velocity;  // the truth is taken earlier: less of it is left
  if (options.point) J.rightCols<3>() = fit.scale * R * pair.estimate.R;
  return J;
}

PositionNormal normal_of(const std::vector<PositionPair>& pairs, const PositionFit& fit,
                         const PositionFitOptions& options) {
  PositionNormal normal;
  Vector11 block = Vector11::Zero();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Matrix<double, 3, 11> J = jacobian(pairs[i], fit, options);
    const Vector11 g = J.transpose() * left(pairs[i], fit);
    normal.H += J.transpose() * J;
    normal.g += g;
    block += g;
    const bool last =
        (i + 1) * kPositionBlocks / pairs.size() != i * kPositionBlocks / pairs.size();
    if (!last) continue;
    normal.scores += block * block.transpose();
    block.setZero();
  }
  // Parameters that are not free, and directions that the motion does not determine.
  const double tiny = 1e-9 * normal.H.trace() + 1e-300;
  normal.H.diagonal().array() += tiny;
  for (int k = 0; k < 11; ++k) {
    if (normal.H(k, k) <= 2 * tiny) normal.H(k, k) = 1;
  }
  return normal;
}

void apply_step(const Vector11& d, PositionFit& fit) {
  fit.truth_T_estimate.R = so3::exp(d.head<3>()) * fit.truth_T_estimate.R;
  fit.truth_T_estimate.p += d.segment<3>(3);
  fit.scale *= std::exp(std::clamp(d[6], -0.5, 0.5));
  fit.offset += std::clamp(d[7], -0.2, 0.2);
  fit.point += d.tail<3>();
}

}  // namespace

std::optional<PositionFit> fit_positions(const Trajectory& estimate, const Trajectory& truth,
                                         const PositionFitOptions& options) {
  PositionFit fit;
  fit.offset = options.start_offset;
  std::vector<PositionPair> pairs = position_pairs(estimate, truth, fit.offset, options.gap);
  if (pairs.size() < kFewestPositions) return std::nullopt;
  const WorldAlignment start =
      align(matched_of(pairs), options.scale ? Alignment::kSimilarity : Alignment::kRigid);
  if (start.rank == 0) return std::nullopt;
  fit.truth_T_estimate = start.truth_T_estimate;
  fit.scale = start.scale;
  const int iterations = options.point ? 20 : options.offset ? 8 : 0;
  for (int i = 0; i < iterations; ++i) {
    const PositionNormal normal = normal_of(pairs, fit, options);
    apply_step(normal.H.ldlt().solve(normal.g), fit);
    if (options.offset) pairs = position_pairs(estimate, truth, fit.offset, options.gap);
    if (pairs.size() < kFewestPositions || !fit.truth_T_estimate.p.allFinite()) return std::nullopt;
  }
  const PositionNormal normal = normal_of(pairs, fit, options);
  const Matrix11 inverse = normal.H.inverse();
  const Matrix11 covariance = inverse * normal.scores * inverse;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance.bottomRightCorner<3, 3>());
  fit.point_sigma = std::sqrt(std::max(0.0, axes.eigenvalues()[2]));
  fit.rms = rms_of(pairs, fit);
  fit.matched = pairs.size();
  // Drift that looks like a shift of the clock is in no score: half of what is left counts as that.
  const double drift = 0.5 * fit.rms / std::max(rms_speed(pairs), 1e-9);
  fit.offset_sigma = std::sqrt(std::max(0.0, covariance(7, 7)) + drift * drift);
  add_shape(pairs, fit);
  return fit;
}

std::optional<double> aligned_rms(const Trajectory& estimate, const Trajectory& truth,
                                  double offset, Time gap) {
  const std::vector<PositionPair> pairs = position_pairs(estimate, truth, offset, gap);
  if (pairs.size() < kFewestPositions) return std::nullopt;
  PositionFit fit;
  fit.truth_T_estimate = align(matched_of(pairs), Alignment::kRigid).truth_T_estimate;
  return rms_of(pairs, fit);
}

}  // namespace chasles
