#include <algorithm>
#include <cmath>
#include <numeric>

#include <chasles/base/median.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/recording/extrinsics.hpp>

namespace chasles {
namespace {

constexpr std::size_t kMostSteps = 250;
constexpr std::size_t kMostPairsOfStep = 40;
constexpr double kTurningRate = 0.1;         // [rad/s]
constexpr double kPixelSigma = 1;            // [px]
constexpr double kOutlierFrom = 2;           // where the cost changes from square to logarithm [px]
constexpr double kLeastAngularSigma = 2e-3;  // [rad/s]
constexpr double kLeastLinearSigma = 0.05;   // [m/s]

/// A point in one frame and its pixel in the next.
struct Pair {
  Eigen::Vector3d p_cam0;
  Eigen::Vector2d seen;
};

Vector6d as_vector(const BodyVelocity& velocity) {
  Vector6d u;
  u << velocity.angular_imu, velocity.linear_imu;
  return u;
}

// White noise of the velocities. The second difference of a smooth signal in noise of sigma s has
// sigma sqrt(6) s, and 1.4826 times the median of its magnitude estimates that.
Vector6d noise_sigma(const std::vector<BodyVelocity>& velocities) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(kLeastAngularSigma),
      Eigen::Vector3d::Constant(kLeastLinearSigma);
  if (velocities.size() < 5) return sigma;
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    std::vector<double> sizes;
    for (std::size_t k = 1; k + 1 < velocities.size(); ++k) {
      sizes.push_back(std::abs(as_vector(velocities[k - 1])[axis] -
                               2 * as_vector(velocities[k])[axis] +
                               as_vector(velocities[k + 1])[axis]));
    }
    sigma[axis] = std::max(sigma[axis], 1.4826 * median(sizes) / std::sqrt(6));
  }
  return sigma;
}

// The steps k -> k+1 in turns, strongest rotation first. The rate is averaged over six samples to
// reduce noise.
std::vector<std::size_t> turning_steps(const std::vector<BodyVelocity>& velocities) {
  std::vector<double> rates;
  for (std::size_t k = 0; k + 1 < velocities.size(); ++k) {
    const std::size_t begin = k < 2 ? 0 : k - 2, end = std::min(k + 4, velocities.size());
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t j = begin; j < end; ++j) sum += velocities[j].angular_imu;
    rates.push_back(sum.norm() / static_cast<double>(end - begin));
  }
  std::vector<std::size_t> steps(rates.size());
  std::iota(steps.begin(), steps.end(), std::size_t{0});
  std::erase_if(steps, [&](std::size_t k) { return rates[k] < kTurningRate; });
  std::stable_sort(steps.begin(), steps.end(),
                   [&](std::size_t a, std::size_t b) { return rates[a] > rates[b]; });
  return steps;
}

std::vector<Pair> common_points(const StereoRig& rig, const FeatureFrame& now,
                                const FeatureFrame& next) {
  std::vector<Pair> pairs;
  auto seen = next.observations.begin();
  for (const StereoObservation& observation : now.observations) {
    while (seen != next.observations.end() && seen->landmark < observation.landmark) ++seen;
    if (seen == next.observations.end() || pairs.size() == kMostPairsOfStep) break;
    if (seen->landmark != observation.landmark) continue;
    const auto point = triangulate(rig, observation.pixels);
    if (point) pairs.push_back({.p_cam0 = point->p_cam0, .seen = seen->pixels.head<2>()});
  }
  return pairs;
}

// The cost of a step (see the header), by iteratively reweighted Gauss-Newton over d.
double step_cost(const StereoRig& rig, const SE3& cam0_T_imu, const std::vector<Pair>& pairs,
                 const Vector6d& u, double dt, const Vector6d& sigma_u) {
  const double c2 = kOutlierFrom * kOutlierFrom;
  const Vector6d prior = sigma_u.cwiseAbs2().cwiseInverse();
  const SE3 imu_T_cam0 = cam0_T_imu.inverse();
  Vector6d d = Vector6d::Zero();
  double cost = 0;
  for (int iteration = 0; iteration < 5; ++iteration) {
    const SE3 next_T_now = se3::exp(-(u + d) * dt);
    Matrix6d information = prior.asDiagonal();
    Vector6d gradient = -prior.cwiseProduct(d);
    cost = d.cwiseAbs2().dot(prior) / 2;
    for (const Pair& pair : pairs) {
      const Eigen::Vector3d p_imu = next_T_now * (imu_T_cam0 * pair.p_cam0);
      const auto projection = project(rig, cam0_T_imu * p_imu);
      if (!projection) continue;
      const Eigen::Vector2d residual = pair.seen - projection->pixels.head<2>();
      const double square = residual.squaredNorm();
      cost += c2 * std::log1p(square / c2) / (2 * kPixelSigma * kPixelSigma);
      Eigen::Matrix<double, 3, 6> d_point;
      d_point << hat(p_imu), -Eigen::Matrix3d::Identity();
      const Eigen::Matrix<double, 2, 6> J =
          projection->d_point.topRows<2>() * (cam0_T_imu.R * dt) * d_point;
      const double weight = 1 / ((1 + square / c2) * kPixelSigma * kPixelSigma);
      information.noalias() += weight * J.transpose() * J;
      gradient.noalias() += weight * J.transpose() * residual;
    }
    d += solve_symmetric(information, gradient);
  }
  return cost;
}

ExtrinsicVerdict compare(const Recording& recording, const std::vector<std::size_t>& steps,
                         std::size_t delay, const SE3& first, const SE3& second) {
  const auto& velocities = recording.velocities;
  const Vector6d sigma_u = noise_sigma(velocities) / std::sqrt(2);
  ExtrinsicVerdict verdict;
  double square_sum = 0;
  for (const std::size_t k : steps) {
    if (static_cast<std::size_t>(verdict.steps) == kMostSteps) break;
    const auto pairs = common_points(recording.rig, recording.frames[k], recording.frames[k + 1]);
    if (pairs.size() < 2) continue;
    const std::size_t begin = std::min(k + delay, velocities.size() - 2);
    const Vector6d u = (as_vector(velocities[begin]) + as_vector(velocities[begin + 1])) / 2;
    const double dt = to_seconds(velocities[k + 1].time - velocities[k].time);
    const double a = step_cost(recording.rig, first, pairs, u, dt, sigma_u);
    const double b = step_cost(recording.rig, second, pairs, u, dt, sigma_u);
    ++verdict.steps;
    verdict.first_cost += a;
    verdict.second_cost += b;
    square_sum += (a - b) * (a - b);
  }
  if (verdict.steps < 2) return {};
  const double n = verdict.steps;
  verdict.first_cost /= n;
  verdict.second_cost /= n;
  const double difference = verdict.first_cost - verdict.second_cost;
  const double variance = (square_sum / n - difference * difference) / (n - 1);
  verdict.sigmas = variance > 0 ? difference / std::sqrt(variance) : 0;
  return verdict;
}

}  // namespace

ExtrinsicVerdict compare_extrinsics(const Recording& recording, const SE3& first,
                                    const SE3& second) {
  const auto steps = turning_steps(recording.velocities);
  const ExtrinsicVerdict own = compare(recording, steps, 0, first, second);
  const ExtrinsicVerdict next = compare(recording, steps, 1, first, second);
  const auto least = [](const ExtrinsicVerdict& v) {
    return std::min(v.first_cost, v.second_cost);
  };
  return least(next) < least(own) ? next : own;
}

}  // namespace chasles
