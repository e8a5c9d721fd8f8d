#pragma once

#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <chasles/filter/pixel_testing.hpp>
#include <chasles/slam/slam_context.hpp>

/// Shared by the tests of single steps of InertialSlam. Included by tests only.
namespace chasles::test {

/// The filter of inertial_filter() with its landmarks 100 to 105 and clones 0 to 2, at frame 3. No
/// gate.
inline SlamContext some_context(Random& random,
                                const Ekf::Options& options = {.map = Ekf::Map::kFrozen}) {
  SlamContext x{.settings = {},
                .cameras = inertial_cameras(),
                .pixel_sigma = 0.8,
                .filter = inertial_filter(kStandardChart, random, true, false, options)};
  x.settings.gate = 1;
  x.records.resize(x.state().landmarks.size());
  x.frame = 3;
  x.now = from_seconds(0.9);
  return x;
}

inline std::vector<const PixelObservation*> pointers(const std::vector<PixelObservation>& pixels) {
  std::vector<const PixelObservation*> result;
  for (const PixelObservation& o : pixels) result.push_back(&o);
  return result;
}

/// A filter after a Kalman update by its equations.
struct Updated {
  State x;
  Eigen::MatrixXd P;
};

/// H by all errors in the standard chart, noise R, residual r.
inline Updated updated(const State& x, const Eigen::MatrixXd& P, const Eigen::MatrixXd& H,
                       const Eigen::MatrixXd& R, const Eigen::VectorXd& r) {
  const Eigen::MatrixXd K = P * H.transpose() * (H * P * H.transpose() + R).inverse();
  const Eigen::MatrixXd I_KH = Eigen::MatrixXd::Identity(P.rows(), P.cols()) - K * H;
  return {moved(kStandardChart, x, K * r), I_KH * P * I_KH.transpose() + K * R * K.transpose()};
}

inline void expect_updated(const Ekf& filter, const Updated& expected) {
  EXPECT_LT(distance(filter.state(), expected.x), 1e-7);
  EXPECT_LT(covariance_difference(filter.covariance(), expected.P), 1e-7);
}

}  // namespace chasles::test
