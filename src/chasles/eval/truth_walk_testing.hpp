#pragma once

#include <functional>

#include <chasles/base/time.hpp>
#include <chasles/eval/truth_reference.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/lie/trajectory.hpp>

/// A walk, its estimate and its truth, for tests of what compares them.
namespace chasles::test {

// A walk of 20 s with turns about all axes, none of which repeats: the sines have no common period.
inline SE3 walk_at(double t) {
  return {so3::exp({0.3 * std::sin(0.9 * t), 0.25 * std::sin(1.3 * t + 1), 0}) *
              so3::exp({0, 0, 0.8 * std::sin(0.5 * t) + 0.3 * std::sin(2.1 * t)}),
          {2 * std::sin(0.4 * t) + 0.2 * std::sin(1.7 * t), 1.5 * std::cos(0.3 * t),
           0.4 * std::sin(0.7 * t)}};
}

inline Trajectory sampled(double hz, double begin, double end,
                          const std::function<SE3(double)>& pose = walk_at) {
  Trajectory trajectory;
  const double base = 1e9;
  for (int i = 0; begin + i / hz <= end; ++i) {
    const double t = begin + i / hz;
    trajectory.push_back(
        {std::chrono::seconds(static_cast<long>(base)) + from_seconds(t), pose(t)});
  }
  return trajectory;
}

inline KnownFrame camera() {
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {"cam0", {so3::exp({0.02, -0.03, 0.01}) * R, {0.1, 0.05, -0.04}}};
}

// 2 mm and 0.1 deg of noise, as an estimate has them, without randomness.
inline TruthReference estimate() {
  TruthReference reference{
      .name = "the estimate", .poses = sampled(20, 1, 20), .level = true, .frames = {camera()}};
  for (std::size_t i = 0; i < reference.poses.size(); ++i) {
    const auto k = static_cast<double>(i);
    SE3& pose = reference.poses[i].pose;
    pose.p += 0.002 * Eigen::Vector3d(std::sin(7.1 * k), std::sin(5.3 * k), std::cos(3.7 * k));
    pose.R *= so3::exp(0.0017 * Eigen::Vector3d(std::sin(6.1 * k), std::cos(4.9 * k), 0));
  }
  return reference;
}

inline Trajectory truth() { return sampled(200, 0, 22); }

inline Trajectory changed(const std::function<void(StampedPose&)>& change) {
  Trajectory poses = truth();
  for (StampedPose& row : poses) change(row);
  return poses;
}

}  // namespace chasles::test
