#include <algorithm>
#include <cmath>

#include <chasles/lie/small_matrices.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/recording/gravity.hpp>

namespace chasles {
namespace {

constexpr double kStep = 1.0;         // between the poses of a window [s]
constexpr double kPoseGap = 0.2;      // [s]
constexpr double kSampleGap = 0.05;   // [s]
constexpr double kSlopeSigma = 0.02;  // of a window's difference of slopes [m/s]
constexpr double kBiasSigma = 0.3;    // [m/s^2]

using Index = std::size_t;

// Runs of poses a step apart, by their indices; a new run begins after a gap.
std::vector<std::vector<Index>> runs_of(const Trajectory& poses) {
  std::vector<std::vector<Index>> runs;
  for (Index k = 0; k < poses.size(); ++k) {
    if (k == 0 || to_seconds(poses[k].time - poses[k - 1].time) > kPoseGap) {
      runs.push_back({k});
    } else if (to_seconds(poses[k].time - poses[runs.back().back()].time) >= kStep) {
      runs.back().push_back(k);
    }
  }
  return runs;
}

// The rotation at a time between poses `k` and `k` + 1.
Eigen::Matrix3d interpolated(const Trajectory& poses, Index k, Time time) {
  const Eigen::Matrix3d& R = poses[k].pose.R;
  const double part =
      to_seconds(time - poses[k].time) / to_seconds(poses[k + 1].time - poses[k].time);
  return R * so3::exp(part * so3::log(R.transpose() * poses[k + 1].pose.R));
}

// The integrals of a window: of h R f and of h R.
struct Integrals {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Zero();
};

// By the trapezoid over the samples; h is zero at both ends. None where samples are missing.
std::optional<Integrals> integrals(const Trajectory& poses, const std::vector<ImuSample>& imu,
                                   Index first, Index middle, Index last) {
  const Time t0 = poses[first].time, t1 = poses[middle].time, t2 = poses[last].time;
  auto sample = std::lower_bound(imu.begin(), imu.end(), t0,
                                 [](const ImuSample& s, Time time) { return s.time < time; });
  if (sample == imu.begin()) ++sample;
  Integrals sum;
  Index k = first;
  for (; sample != imu.end() && sample->time < t2; ++sample) {
    if (sample + 1 == imu.end()) return std::nullopt;
    const double before = to_seconds(sample->time - std::prev(sample)->time);
    const double after = to_seconds(std::next(sample)->time - sample->time);
    if (std::max(before, after) > kSampleGap) return std::nullopt;
    while (poses[k + 1].time <= sample->time) ++k;
    const double h = sample->time < t1 ? to_seconds(sample->time - t0) / to_seconds(t1 - t0)
                                       : to_seconds(t2 - sample->time) / to_seconds(t2 - t1);
    const Eigen::Matrix3d R = h * (before + after) / 2 * interpolated(poses, k, sample->time);
    sum.force += R * sample->specific_force_imu;
    sum.rotation += R;
  }
  return sample == imu.end() ? std::nullopt : std::optional(sum);
}

// The normal equations for [bias; gravity].
struct GravityEquations {
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
  double squares = 0;  // of the right-hand side
  int windows = 0;

  void add(const Trajectory& poses, const Integrals& sum, Index first, Index middle, Index last) {
    const double before = to_seconds(poses[middle].time - poses[first].time);
    const double after = to_seconds(poses[last].time - poses[middle].time);
    const Eigen::Vector3d slopes = (poses[last].pose.p - poses[middle].pose.p) / after -
                                   (poses[middle].pose.p - poses[first].pose.p) / before;
    Eigen::Matrix<double, 3, 6> J;
    J << -sum.rotation, (before + after) / 2 * Eigen::Matrix3d::Identity();
    A += J.transpose() * J;
    b += J.transpose() * (slopes - sum.force);
    squares += (slopes - sum.force).squaredNorm();
    ++windows;
  }
};

}  // namespace

std::optional<GravityFit> fit_gravity(const Trajectory& world_T_imu,
                                      const std::vector<ImuSample>& imu) {
  if (imu.size() < 2) return std::nullopt;
  GravityEquations equations;
  for (const auto& run : runs_of(world_T_imu)) {
    for (Index i = 2; i < run.size(); ++i) {
      if (world_T_imu[run[i - 2]].time < imu.front().time) continue;
      const auto sum = integrals(world_T_imu, imu, run[i - 2], run[i - 1], run[i]);
      if (sum) equations.add(world_T_imu, *sum, run[i - 2], run[i - 1], run[i]);
    }
  }
  if (equations.windows < 3) return std::nullopt;
  const double prior = kSlopeSigma / kBiasSigma;
  equations.A.topLeftCorner<3, 3>().diagonal().array() += prior * prior;
  const Eigen::Matrix<double, 6, 1> x = solve_symmetric(equations.A, equations.b);
  return GravityFit{
      .gravity_world = x.tail<3>(),
      .accelerometer_bias = x.head<3>(),
      .windows = equations.windows,
      .left = std::sqrt(std::max(0.0, equations.squares - x.dot(equations.b)) / equations.windows)};
}

}  // namespace chasles
