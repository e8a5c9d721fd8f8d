#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <gtest/gtest.h>

#include <chasles/filter/ekf.hpp>
#include <chasles/lie/testing.hpp>

/// Shared by the filter's tests: all charts, random states, and statistics with bounds. Included by
/// tests only.
namespace chasles::test {

/// A test over all charts of error_charts().
class OverCharts : public ::testing::TestWithParam<const ErrorChart*> {
 protected:
  const ErrorChart& chart() const { return *GetParam(); }
};

inline std::vector<const ErrorChart*> all_charts() {
  std::vector<const ErrorChart*> result;
  for (const ErrorChart& chart : error_charts()) result.push_back(&chart);
  return result;
}

/// GoogleTest's name of a chart: no dashes allowed.
inline std::string chart_test_name(const ::testing::TestParamInfo<const ErrorChart*>& info) {
  std::string name(info.param->name);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

inline SE3 random_pose(Random& random, double metres) {
  // One draw a statement, here and elsewhere: compilers choose the order within one.
  const Eigen::Vector3d axis = random.axis();
  const double angle = random.uniform(0, 3);
  return {so3::exp(angle * axis), metres * random.normal_vector(3)};
}

/// Parts of a random state. `gap` unused rows precede every landmark, like the rows of retired ones
/// in a filter that does not compress its map. Clones and landmarks alternate, a clone first; with
/// `anchored`, every second landmark is anchored on the clone before it.
struct StateShape {
  bool velocity = false;
  int additive = 0;
  int landmarks = 0;
  int gap = 0;
  bool nav = false;
  int clones = 0;
  bool anchored = false;
};

/// An anchored landmark some metres in front of a camera that is not at the IMU.
inline Landmark random_anchored(Random& random, LandmarkId id, int anchor) {
  return {.id = id,
          .p_world = random.normal_vector(3),  // without meaning in this form
          .observations = 1,
          .anchor = anchor,
          .cam_T_imu = random_pose(random, 0.2),
          .inverse_depth = {random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5),
                            random.uniform(0.1, 0.5)}};
}

inline State random_state(Random& random, const StateShape& shape) {
  State x;
  x.world_T_imu = random_pose(random, 20);
  x.additive = random.normal_vector(shape.additive);
  if (shape.velocity) x.v_world = 5 * random.normal_vector(3);
  if (shape.nav) x.nav_T_world = random_pose(random, 20);
  int row = x.core_size();
  for (int i = 0; i < std::max(shape.landmarks, shape.clones); ++i) {
    if (i < shape.clones) {
      x.clones.push_back(
          {.id = 10 + i, .time = {}, .world_T_imu = random_pose(random, 20), .row = row});
      row += 6;
    }
    if (i >= shape.landmarks) continue;
    row += shape.gap;
    if (shape.anchored && i % 2 == 0) {
      x.landmarks.push_back(random_anchored(random, i, x.clones.back().id));
    } else {
      x.landmarks.push_back({.id = i, .p_world = 20 * random.normal_vector(3), .observations = 1});
    }
    x.landmarks.back().row = row;
    row += 3;
  }
  return x;
}

/// Rows of the error vector of a state without further rows.
inline int error_rows(const State& x) { return x.size(); }

inline State moved(const ErrorChart& chart, State x, const Eigen::VectorXd& xi) {
  retract(chart, x, xi);
  return x;
}

inline double distance(const SE3& x, const SE3& y) {
  return std::max((x.R - y.R).cwiseAbs().maxCoeff(), (x.p - y.p).cwiseAbs().maxCoeff());
}

/// The largest difference of two states over all their components.
inline double distance(const State& x, const State& y) {
  double d = distance(x.world_T_imu, y.world_T_imu);
  if (x.v_world) d = std::max(d, (*x.v_world - *y.v_world).cwiseAbs().maxCoeff());
  if (x.nav_T_world) d = std::max(d, distance(*x.nav_T_world, *y.nav_T_world));
  if (x.additive.size() > 0) d = std::max(d, (x.additive - y.additive).cwiseAbs().maxCoeff());
  for (std::size_t i = 0; i < x.imu_T_camera.size(); ++i) {
    d = std::max(d, distance(x.imu_T_camera[i], y.imu_T_camera[i]));
  }
  if (x.time_offset) d = std::max(d, std::abs(*x.time_offset - *y.time_offset));
  if (x.imu) {
    d = std::max(d, (x.imu->parameters() - y.imu->parameters()).cwiseAbs().maxCoeff());
  }
  for (std::size_t i = 0; i < x.landmarks.size(); ++i) {
    const Eigen::Vector3d between = x.landmarks[i].parameters() - y.landmarks[i].parameters();
    d = std::max(d, between.cwiseAbs().maxCoeff());
  }
  for (std::size_t i = 0; i < x.clones.size(); ++i) {
    d = std::max(d, distance(x.clones[i].world_T_imu, y.clones[i].world_T_imu));
  }
  return d;
}

/// A covariance with correlations everywhere and standard deviations about `sigma`.
inline Eigen::MatrixXd random_covariance(Random& random, int n, double sigma) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n);
  for (int j = 0; j < n; ++j) A.col(j) += 0.5 * random.normal_vector(n) / std::sqrt(n);
  const Eigen::MatrixXd P = sigma * sigma * A * A.transpose();
  return P.selfadjointView<Eigen::Lower>();
}

inline Eigen::VectorXd normal_of(Random& random, const Eigen::MatrixXd& covariance) {
  return covariance.llt().matrixL() * random.normal_vector(covariance.rows());
}

/// Interval of a chi-square variable with probability 0.999 (Wilson & Hilferty 1931; at 6 degrees
/// of freedom and more its bounds are good to 1 %).
struct Chi2Bounds {
  double low, high;
  explicit Chi2Bounds(double dof) {
    constexpr double kNormalQuantile = 3.2905;
    const auto at = [&](double z) {
      return dof * std::pow(1 - 2 / (9 * dof) + z * std::sqrt(2 / (9 * dof)), 3);
    };
    low = at(-kNormalQuantile);
    high = at(kNormalQuantile);
  }
};

inline ::testing::AssertionResult is_chi2(double sum, double dof) {
  const Chi2Bounds bounds(dof);
  if (bounds.low <= sum && sum <= bounds.high) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << sum / dof << " a degree of freedom, of " << dof << "; the bounds are "
         << bounds.low / dof << " and " << bounds.high / dof;
}

/// Whether the columns of `samples` have mean 0 and this covariance, within the statistical
/// uncertainty (5 standard deviations in every component of the whitened moments).
inline ::testing::AssertionResult has_covariance(const Eigen::MatrixXd& samples,
                                                 const Eigen::MatrixXd& covariance) {
  const double n = static_cast<double>(samples.cols());
  const Eigen::MatrixXd white = covariance.llt().matrixL().solve(samples);
  const Eigen::MatrixXd second = white * white.transpose() / n;
  const double mean = white.rowwise().mean().cwiseAbs().maxCoeff() * std::sqrt(n);
  Eigen::MatrixXd excess = second - Eigen::MatrixXd::Identity(second.rows(), second.cols());
  excess.diagonal() /= std::sqrt(2.0);
  const double spread = excess.cwiseAbs().maxCoeff() * std::sqrt(n);
  if (mean < 5 && spread < 5) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "the mean is " << mean << ", the second moments are "
                                       << spread << " standard deviations away; whitened moments\n"
                                       << second;
}

/// Largest difference of two covariances, every entry in units of its two standard deviations.
/// Their lower limit is a millionth of the largest standard deviation, for errors known to be zero.
inline double covariance_difference(const Eigen::MatrixXd& actual,
                                    const Eigen::MatrixXd& expected) {
  const double least = 1e-12 * expected.diagonal().maxCoeff();
  const Eigen::VectorXd scale = expected.diagonal().cwiseMax(least).cwiseSqrt().cwiseInverse();
  return (scale.asDiagonal() * (actual - expected) * scale.asDiagonal()).cwiseAbs().maxCoeff();
}

}  // namespace chasles::test
