#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include <Eigen/LU>
#include <Eigen/SVD>

#include <chasles/base/median.hpp>
#include <chasles/calibrate/frame_lag.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr int kMostFrames = 3;
constexpr std::size_t kLeastPairs = 10;
constexpr double kClearly = 0.3;  // of the scatter by the stated times

// The scatter of the relative attitude [rad]: median angle to the mean.
std::optional<double> attitude_scatter(const std::vector<Time>& times,
                                       const std::map<Time, SE3>& first,
                                       const std::map<Time, SE3>& second, int frames) {
  std::vector<Eigen::Matrix3d> relative;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto later = static_cast<std::ptrdiff_t>(k) + frames;
    if (later < 0 || later >= std::ssize(times)) continue;
    const auto a = first.find(times[k]);
    const auto b = second.find(times[static_cast<std::size_t>(later)]);
    if (a == first.end() || b == second.end()) continue;
    relative.emplace_back(b->second.R * a->second.R.transpose());
    sum += relative.back();
  }
  if (relative.size() < kLeastPairs) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  if (U.determinant() * svd.matrixV().determinant() < 0) U.col(2) = -U.col(2);
  const Eigen::Matrix3d mean = U * svd.matrixV().transpose();
  std::vector<double> angles;
  for (const Eigen::Matrix3d& one : relative) {
    angles.push_back(so3::log(one * mean.transpose()).norm());
  }
  return median(std::move(angles));
}

}  // namespace

std::optional<FrameLag> frame_lag(const std::map<Time, SE3>& first,
                                  const std::map<Time, SE3>& second) {
  std::vector<Time> times;
  for (const auto& [time, pose] : first) times.push_back(time);
  for (const auto& [time, pose] : second) times.push_back(time);
  std::ranges::sort(times);
  times.erase(std::unique(times.begin(), times.end()), times.end());
  const std::optional<double> stated = attitude_scatter(times, first, second, 0);
  if (!stated) return std::nullopt;
  FrameLag best;
  double least = kClearly * *stated;
  for (int frames = -kMostFrames; frames <= kMostFrames; ++frames) {
    const std::optional<double> scatter = attitude_scatter(times, first, second, frames);
    if (!scatter || *scatter >= least) continue;
    least = *scatter;
    best.frames = frames;
  }
  if (best.frames == 0) return std::nullopt;
  std::vector<double> steps;
  for (std::size_t k = 1; k < times.size(); ++k)
    steps.push_back(to_seconds(times[k] - times[k - 1]));
  best.seconds = std::abs(best.frames) * median(std::move(steps));
  return best;
}

}  // namespace chasles
