#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <Eigen/SVD>

#include <chasles/eval/alignment.hpp>

namespace chasles {
namespace {

// Singular values below these, relative to the largest, are round-off.
constexpr double kLine = 1e-13;
constexpr double kPoint = 1e-12;

// The sums of all least-squares alignments. Positions are relative to their means.
struct Moments {
  Eigen::Vector3d mean_estimate = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_truth = Eigen::Vector3d::Zero();
  Eigen::Matrix3d position = Eigen::Matrix3d::Zero();  // sum of truth estimate^T
  Eigen::Matrix3d attitude = Eigen::Matrix3d::Zero();  // sum of R_truth R_estimate^T
  double spread_estimate = 0;                          // sum of |estimate|^2
  double spread_truth = 0;
  double magnitude = 0;  // largest coordinate: the scale of round-off
};

Moments moments(const MatchedTrajectories& matched) {
  Moments m;
  const auto n = static_cast<double>(matched.truth.size());
  for (std::size_t i = 0; i < matched.truth.size(); ++i) {
    m.mean_estimate += matched.estimate[i].pose.p / n;
    m.mean_truth += matched.truth[i].pose.p / n;
  }
  for (std::size_t i = 0; i < matched.truth.size(); ++i) {
    const SE3& estimate = matched.estimate[i].pose;
    const SE3& truth = matched.truth[i].pose;
    const Eigen::Vector3d p = estimate.p - m.mean_estimate;
    const Eigen::Vector3d q = truth.p - m.mean_truth;
    m.position += q * p.transpose();
    m.attitude += truth.R * estimate.R.transpose();
    m.spread_estimate += p.squaredNorm();
    m.spread_truth += q.squaredNorm();
    m.magnitude =
        std::max({m.magnitude, estimate.p.cwiseAbs().maxCoeff(), truth.p.cwiseAbs().maxCoeff()});
  }
  return m;
}

// The rotation R that maximises trace(R^T M), and the singular values. The last one is negative if
// M's nearest orthogonal matrix is a reflection (Umeyama, eq. 40-43).
struct Procrustes {
  Eigen::Matrix3d R;
  Eigen::Vector3d values;
  Eigen::Vector3d first_axis;  // of the truth
};

Procrustes procrustes(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
  return {svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose(),
          svd.singularValues().cwiseProduct(sign), svd.matrixU().col(0)};
}

// The rotation about the unit vector `axis` that maximises trace(Exp(angle axis)^T M).
Eigen::Matrix3d best_turn(const Eigen::Vector3d& axis, const Eigen::Matrix3d& M) {
  const double sine = (hat(axis).transpose() * M).trace();
  const double cosine = M.trace() - axis.dot(M * axis);
  return so3::exp(std::atan2(sine, cosine) * axis);
}

bool is_point(const Moments& m) {
  const double round_off = kPoint * m.magnitude;
  const double smaller = std::min(m.spread_estimate, m.spread_truth);
  return smaller == 0 || std::sqrt(smaller) <= round_off;
}

WorldAlignment least_squares(const Moments& m, bool with_scale) {
  WorldAlignment result;
  const Procrustes positions = procrustes(m.position);
  if (is_point(m)) {
    result.rank = 0;
    result.truth_T_estimate.R = procrustes(m.attitude).R;
  } else if (positions.values[1] <= kLine * positions.values[0]) {
    result.rank = 1;
    const Eigen::Matrix3d turn =
        best_turn(positions.first_axis, m.attitude * positions.R.transpose());
    result.truth_T_estimate.R = turn * positions.R;
  } else {
    result.truth_T_estimate.R = positions.R;
  }
  if (with_scale && result.rank > 0) result.scale = positions.values.sum() / m.spread_estimate;
  return result;
}

WorldAlignment position_yaw(const Moments& m) {
  WorldAlignment result;
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const double horizontal = m.position.topLeftCorner<2, 2>().norm();
  const double all = std::sqrt(m.spread_estimate * m.spread_truth);
  const bool decided = !is_point(m) && horizontal > kLine * all;
  result.rank = decided ? 2 : 0;
  result.truth_T_estimate.R = best_turn(up, decided ? m.position : m.attitude);
  return result;
}

}  // namespace

std::string_view name(Alignment alignment) {
  switch (alignment) {
    case Alignment::kNone:
      return "none";
    case Alignment::kFirstPose:
      return "first pose";
    case Alignment::kFirstLevel:
      return "first position + yaw";
    case Alignment::kPositionYaw:
      return "position + yaw";
    case Alignment::kRigid:
      return "SE(3)";
    case Alignment::kSimilarity:
      return "Sim(3)";
  }
  return "";
}

SE3 WorldAlignment::operator()(const SE3& pose) const {
  return {truth_T_estimate.R * pose.R, truth_T_estimate * Eigen::Vector3d(scale * pose.p)};
}

WorldAlignment align(const MatchedTrajectories& matched, Alignment alignment) {
  if (alignment == Alignment::kNone || matched.truth.empty()) return {};
  if (alignment == Alignment::kFirstPose) {
    return {.truth_T_estimate =
                matched.truth.front().pose * matched.estimate.front().pose.inverse()};
  }
  if (alignment == Alignment::kFirstLevel) {
    return align({.estimate = {matched.estimate.front()},
                  .truth = {matched.truth.front()},
                  .estimate_index = {0}},
                 Alignment::kPositionYaw);
  }
  const Moments m = moments(matched);
  WorldAlignment result = alignment == Alignment::kPositionYaw
                              ? position_yaw(m)
                              : least_squares(m, alignment == Alignment::kSimilarity);
  result.truth_T_estimate.p =
      m.mean_truth - result.truth_T_estimate.R * Eigen::Vector3d(result.scale * m.mean_estimate);
  return result;
}

}  // namespace chasles
