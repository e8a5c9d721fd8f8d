#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <chasles/lie/so3.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/loop/landmark_map.hpp>

/// Shared by the tests of maps. Included by tests only.
namespace chasles::test {

inline Descriptor random_descriptor(Random& random) {
  return {random.next(), random.next(), random.next(), random.next()};
}

/// A view with random descriptors, from a point at this offset [m].
inline PatchView random_view(Random& random, const Eigen::Vector3d& to_camera) {
  PatchView view{.from = to_camera.normalized().cast<float>(),
                 .level = static_cast<int>(std::lround(2 * std::log2(2 * to_camera.norm())))};
  for (Descriptor& descriptor : view.descriptors) descriptor = random_descriptor(random);
  return view;
}

/// As another camera sees it: some bits differ.
inline PatchView seen_again(Random& random, PatchView view, int bits) {
  for (Descriptor& descriptor : view.descriptors) {
    for (int i = 0; i < bits; ++i) {
      descriptor[random.next() % 4] ^= std::uint64_t{1} << (random.next() % 64);
    }
  }
  return view;
}

/// Points on the walls of a corridor along x, each seen from 3 m before it, with errors that drift
/// along the corridor beside their own ones.
inline LandmarkMap corridor_map(std::uint64_t seed, int points, double length, int rank = 6) {
  Random random(seed);
  LandmarkMap map;
  map.sessions.push_back({.name = "corridor", .begin = Time(5), .end = Time(10), .cameras = {}});
  std::vector<Eigen::Matrix3d> own;
  Eigen::MatrixXd shared(3 * points, rank);
  for (int i = 0; i < points; ++i) {
    const double x = length * (i + random.uniform()) / points;
    const double side = i % 2 == 0 ? 1.5 : -1.5;
    const Eigen::Vector3d p(x, side, random.uniform(-1.2, 1.4));
    MapPoint point{.p_map = p, .session = 0, .observations = 10 + i % 30};
    point.appearance.add(random_view(random, Eigen::Vector3d(x - 3, 0, 0) - p));
    map.points.push_back(std::move(point));
    own.emplace_back(std::pow(0.01 + 0.01 * random.uniform(), 2) * Eigen::Matrix3d::Identity());
    for (int k = 0; k < rank; ++k) {
      const double phase = std::numbers::pi * (k + 1) * x / length;
      for (int axis = 0; axis < 3; ++axis) {
        shared(3 * i + axis, k) = 0.05 / (k + 1) * std::sin(phase + axis + k);
      }
    }
  }
  map.covariance = JointCovariance(std::move(own), std::move(shared));
  return map;
}

/// All points' joint covariance.
inline Eigen::MatrixXd whole_covariance(const JointCovariance& covariance) {
  std::vector<int> all;
  for (int i = 0; i < covariance.points(); ++i) all.push_back(i);
  return covariance.of(all);
}

/// A level frame: turned about the vertical [rad] and moved [m].
inline SE3 level_pose(double heading, const Eigen::Vector3d& p) {
  return {so3::exp({0, 0, heading}), p};
}

/// What a walk leaves of the part of a corridor between two x: its points with errors that are
/// drawn from their covariance, as another camera sees them, in the frame of the walk. `indices`
/// receives those of the points.
inline LandmarkMap walk_map(const LandmarkMap& corridor, double from, double to,
                            const SE3& walk_T_corridor, int number, Random& random,
                            std::vector<int>* indices = nullptr) {
  LandmarkMap map;
  map.sessions.push_back({.name = "walk-" + std::to_string(number),
                          .begin = Time(10 * number),
                          .end = Time(10 * number + 5),
                          .cameras = {}});
  const Eigen::VectorXd y = random.normal_vector(corridor.covariance.rank());
  const Eigen::Matrix3d& R = walk_T_corridor.R;
  std::vector<Eigen::Matrix3d> own;
  std::vector<Eigen::MatrixXd> rows;
  for (std::size_t i = 0; i < corridor.points.size(); ++i) {
    MapPoint point = corridor.points[i];
    if (point.p_map.x() < from || point.p_map.x() > to) continue;
    if (indices) indices->push_back(static_cast<int>(i));
    const Eigen::Matrix3d& D = corridor.covariance.own()[i];
    const Eigen::MatrixXd U =
        corridor.covariance.shared().middleRows<3>(3 * static_cast<Eigen::Index>(i));
    point.p_map =
        walk_T_corridor * (point.p_map + U * y + std::sqrt(D(0, 0)) * random.normal_vector(3));
    Appearance again;
    again.add(seen_again(random, point.appearance.views().front(), 10));
    point.appearance = again.turned(R);
    map.points.push_back(std::move(point));
    own.emplace_back(R * D * R.transpose());
    rows.emplace_back(R * U);
  }
  Eigen::MatrixXd shared(3 * static_cast<Eigen::Index>(own.size()), corridor.covariance.rank());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    shared.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = rows[i];
  }
  map.covariance = JointCovariance(std::move(own), std::move(shared));
  return map;
}

}  // namespace chasles::test
