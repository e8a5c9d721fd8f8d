#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/LU>
#include <Eigen/SVD>

#include <chasles/base/constants.hpp>
#include <chasles/eval/attitude_fit.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr std::size_t kFewestAttitudes = 10, kMostAttitudes = 3000;
constexpr int kAlternations = 200;

struct AttitudePair {
  Eigen::Matrix3d estimate, truth;
};

std::vector<AttitudePair> attitude_pairs(const Trajectory& estimate, const Trajectory& truth,
                                         const AttitudeFitOptions& options) {
  const std::size_t every = estimate.size() / kMostAttitudes + 1;
  std::vector<AttitudePair> pairs;
  for (std::size_t i = 0; i < estimate.size(); i += every) {
    const Time time = estimate[i].time - from_seconds(options.offset);
    if (const auto pose = pose_at(truth, time, options.gap)) {
      pairs.push_back({estimate[i].pose.R, pose->R});
    }
  }
  return pairs;
}

// The rotation with the smallest sum of squared chordal distances from those whose sum is M.
Eigen::Matrix3d chordal_mean(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

Eigen::Matrix3d mean_world(const std::vector<AttitudePair>& pairs, const Eigen::Matrix3d& body) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const AttitudePair& pair : pairs) sum += pair.truth * (pair.estimate * body).transpose();
  return chordal_mean(sum);
}

Eigen::Matrix3d mean_body(const std::vector<AttitudePair>& pairs, const Eigen::Matrix3d& world) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const AttitudePair& pair : pairs) sum += (world * pair.estimate).transpose() * pair.truth;
  return chordal_mean(sum);
}

double rms_angle(const std::vector<AttitudePair>& pairs, const AttitudeFit& fit) {
  double sum = 0;
  for (const AttitudePair& pair : pairs) {
    const Eigen::Matrix3d expected = fit.truth_R_estimate * pair.estimate * fit.body;
    sum += so3::log(expected.transpose() * pair.truth).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(pairs.size()));
}

double rms_excursion(const std::vector<AttitudePair>& pairs) {
  Eigen::Matrix3d total = Eigen::Matrix3d::Zero();
  for (const AttitudePair& pair : pairs) total += pair.estimate;
  const Eigen::Matrix3d mean = chordal_mean(total);
  double sum = 0;
  for (const AttitudePair& pair : pairs) {
    sum += so3::log(mean.transpose() * pair.estimate).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(pairs.size()));
}

}  // namespace

std::optional<AttitudeFit> fit_attitudes(const Trajectory& estimate, const Trajectory& truth,
                                         const AttitudeFitOptions& options) {
  const std::vector<AttitudePair> pairs = attitude_pairs(estimate, truth, options);
  if (pairs.size() < kFewestAttitudes) return std::nullopt;
  AttitudeFit fit{.matched = pairs.size()};
  const bool world = !options.truth_R_estimate;
  if (!world) fit.truth_R_estimate = *options.truth_R_estimate;
  const int passes = world && options.body ? kAlternations : 1;
  for (int i = 0; i < passes; ++i) {
    if (world) fit.truth_R_estimate = mean_world(pairs, fit.body);
    if (options.body) fit.body = mean_body(pairs, fit.truth_R_estimate);
  }
  fit.rms = rms_angle(pairs, fit);
  fit.excursion = rms_excursion(pairs);
  return fit;
}

double unlike_attitudes_limit(const AttitudeFit& fit) {
  return std::max(5 * kRadians, fit.excursion / 2);
}

}  // namespace chasles
