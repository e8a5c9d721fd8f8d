#pragma once

#include <cmath>

#include <chasles/lie/testing.hpp>
#include <chasles/lie/trajectory.hpp>

/// Trajectories in closed form for the tests of this folder.
namespace chasles::test {

/// A pose every 0.1 s.
inline Time stamp(std::size_t i) { return Time(100'000'000LL * static_cast<long long>(i)); }

/// A rising helix of radius 50 m with oscillating attitude; 5 m per pose.
inline Trajectory helix(std::size_t n) {
  Trajectory trajectory;
  for (std::size_t i = 0; i < n; ++i) {
    const double a = 0.1 * static_cast<double>(i);
    const SE3 pose{
        so3::exp({0, 0, a + std::numbers::pi / 2}) * so3::exp({0.05 * std::sin(3 * a), 0.1, 0}),
        {50 * std::cos(a), 50 * std::sin(a), 2 * a}};
    trajectory.push_back({stamp(i), pose});
  }
  return trajectory;
}

/// Motion along x without rotation.
inline Trajectory straight(std::size_t n, double spacing) {
  Trajectory trajectory;
  for (std::size_t i = 0; i < n; ++i) {
    trajectory.push_back(
        {stamp(i),
         {.R = Eigen::Matrix3d::Identity(), .p = {spacing * static_cast<double>(i), 0, 0}}});
  }
  return trajectory;
}

/// The trajectory in another world.
inline Trajectory moved(const SE3& transform, Trajectory trajectory) {
  for (StampedPose& row : trajectory) row.pose = transform * row.pose;
  return trajectory;
}

inline SE3 some_transform() { return {so3::exp({0.3, -0.8, 1.9}), Eigen::Vector3d(120, -40, 7)}; }

}  // namespace chasles::test
