#include <algorithm>
#include <cmath>
#include <vector>

#include <chasles/lie/so3.hpp>
#include <chasles/velocity/level_axes.hpp>

namespace chasles {
namespace {

constexpr double kLeastCosine = 0.05;  // of the elevation of the x axis
constexpr double kLag = 0.5;           // [s]: longer than a sample's noise, shorter than a hill
constexpr double kLeastSpeed = 2;      // [m/s]
constexpr double kLeastPairs = 20;
constexpr double kLeastPitch = 1e-6;  // [rad]: round-off

// The pitch [rad] at every sample, integrated from the rates; nose up is positive.
std::vector<double> pitches(std::span<const BodyVelocity> velocities) {
  std::vector<double> pitch(velocities.size());
  for (std::size_t k = 1; k < velocities.size(); ++k) {
    const double rate = (velocities[k - 1].angular_imu.y() + velocities[k].angular_imu.y()) / 2;
    pitch[k] = pitch[k - 1] - rate * to_seconds(velocities[k].time - velocities[k - 1].time);
  }
  return pitch;
}

}  // namespace

std::optional<LevelAxes> level_axes(const Eigen::Vector3d& up_imu) {
  const double sine = up_imu.x(), cosine = std::hypot(up_imu.y(), up_imu.z());
  if (!(cosine > kLeastCosine)) return std::nullopt;
  LevelAxes axes;
  const Eigen::Vector3d forward = (Eigen::Vector3d::UnitX() - sine * up_imu) / cosine;
  axes.level_R_imu << forward.transpose(), (hat(up_imu) * forward).transpose(), up_imu.transpose();
  // If the vertical moves by a along x and b along y, the axes rotate by (b, -a) about these. They
  // rotate about the vertical such that the body's x axis has no y component.
  Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
  turn(0, 1) = 1;
  turn(1, 0) = -1;
  turn(2, 1) = sine / cosine;
  axes.by_vertical = turn * axes.level_R_imu;
  return axes;
}

std::optional<LevelEvidence> level_evidence(std::span<const BodyVelocity> velocities) {
  const std::vector<double> pitch = pitches(velocities);
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, steps = 0;
  for (std::size_t k = 0, later = 0; k < velocities.size(); ++k) {
    const auto since = [&](std::size_t j) {
      return to_seconds(velocities[j].time - velocities[k].time);
    };
    later = std::max(later, k);
    while (later < velocities.size() && since(later) < kLag - 1e-6) ++later;
    if (later == velocities.size()) break;
    const Eigen::Vector3d &now = velocities[k].linear_imu, &then = velocities[later].linear_imu;
    const bool moves = std::abs(now.x()) >= kLeastSpeed && std::abs(then.x()) >= kLeastSpeed;
    if (since(later) > 1.5 * kLag || !moves) continue;
    // Divided by the signed forward speed: a car that drives backwards up a hill is nose down.
    const double dx = pitch[later] - pitch[k], dy = then.z() / then.x() - now.z() / now.x();
    n += 1;
    x += dx;
    y += dy;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
    steps += static_cast<double>(later - k);
  }
  // The means are subtracted: a gyroscope bias is not pitch motion.
  xx -= x * x / n;
  xy -= x * y / n;
  yy -= y * y / n;
  if (n < kLeastPairs || !(xx > kLeastPitch * kLeastPitch * n)) return std::nullopt;
  // Number of independent pairs among the overlapping ones.
  const double slope = xy / xx, overlap = steps / n;
  const double variance = std::max(0.0, yy - slope * xy) / n * overlap / xx;
  return LevelEvidence{.slope = slope, .sigma = std::sqrt(variance)};
}

}  // namespace chasles
