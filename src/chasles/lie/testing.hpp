#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <sstream>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

/// Shared by the tests of all folders: platform-independent seeded random numbers, the grid of
/// critical rotation angles, numeric derivatives, and a relative comparison. Included by tests
/// only.
namespace chasles::test {

/// Reproducible random numbers: splitmix64 (Steele, Lea, Flood 2014) with Box-Muller.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }

  /// Uniform in (0, 1).
  double uniform() { return (static_cast<double>(next() >> 11) + 0.5) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Normal with mean 0 and standard deviation 1.
  double normal() {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

  /// n independent normal numbers.
  Eigen::VectorXd normal_vector(Eigen::Index n) {
    Eigen::VectorXd v(n);
    for (double& x : v) x = normal();
    return v;
  }

  /// A direction, uniform on the sphere.
  Eigen::Vector3d axis() { return normal_vector(3).normalized(); }

 private:
  std::uint64_t state_;
};

/// Angles [rad] below pi where rotation formulas change branch or lose digits.
inline std::vector<double> angles_below_pi() {
  constexpr double pi = std::numbers::pi;
  return {0,    1e-12, 1e-8,     1e-6, 1e-4,     1e-3,     1e-2, 1e-1,      0.5 - 1e-9, 0.5 + 1e-9,
          0.99, 1.0,   1 + 1e-9, 1.5,  2 - 1e-9, 2 + 1e-9, 3,    pi - 1e-3, pi - 1e-6};
}

/// The same, and angles above pi, where exp and the Jacobians are still defined.
inline std::vector<double> angles() {
  std::vector<double> all = angles_below_pi();
  for (double angle : {std::numbers::pi, 3.5, 5.0, 6.0}) all.push_back(angle);
  return all;
}

/// The coordinate axes, their opposites where a sign matters, and oblique directions.
inline std::vector<Eigen::Vector3d> axes() {
  return {{1, 0, 0},
          {0, 1, 0},
          {0, 0, 1},
          {-1, 0, 0},
          {0, 0, -1},
          Eigen::Vector3d(1, 1, 0).normalized(),
          Eigen::Vector3d(1, -2, 3).normalized(),
          Eigen::Vector3d(-3, 1e-3, 0.5).normalized(),
          Eigen::Vector3d(1e-9, 1, -1e-9).normalized()};
}

/// d f / d x by a five-point central difference, rows = f's size, columns = x's size. `step` is
/// relative to max(1, |x_i|); the error is about 1e-12 for functions that vary on the scale of 1.
template <typename Function, typename Derived>
Eigen::MatrixXd numeric_derivative(const Function& f, const Eigen::MatrixBase<Derived>& x,
                                   double step = 1e-3) {
  using Point = typename Derived::PlainObject;
  const auto value = [&](Eigen::Index i, double offset) -> Eigen::VectorXd {
    Point moved = x;
    moved[i] += offset;
    return Eigen::VectorXd(f(moved));
  };
  const Point at = x;
  Eigen::MatrixXd D(Eigen::VectorXd(f(at)).size(), x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double h = step * std::max(1.0, std::abs(at[i]));
    D.col(i) = (8 * (value(i, h) - value(i, -h)) - (value(i, 2 * h) - value(i, -2 * h))) / (12 * h);
  }
  return D;
}

/// Largest difference of two equally sized matrices, divided by the largest entry of `expected` or
/// by `floor`, whichever is larger (the zero case).
template <typename A, typename B>
double relative_difference(const A& actual, const B& expected, double floor = 1.0) {
  const Eigen::MatrixXd a = actual;
  const Eigen::MatrixXd b = expected;
  if (a.size() == 0) return 0;
  return (a - b).cwiseAbs().maxCoeff() / std::max(floor, b.cwiseAbs().maxCoeff());
}

/// EXPECT_TRUE(agree(actual, expected, 1e-12)): same size and relative_difference within the
/// tolerance (a NaN anywhere disagrees); prints both otherwise.
template <typename A, typename B>
::testing::AssertionResult agree(const A& actual, const B& expected, double tolerance,
                                 double floor = 1.0) {
  const Eigen::MatrixXd a = actual;
  const Eigen::MatrixXd b = expected;
  std::ostringstream text;
  text.precision(17);
  if (a.rows() != b.rows() || a.cols() != b.cols()) {
    text << "sizes " << a.rows() << "x" << a.cols() << " and " << b.rows() << "x" << b.cols();
    return ::testing::AssertionFailure() << text.str();
  }
  const double difference = relative_difference(a, b, floor);
  if (difference <= tolerance && a.allFinite() && b.allFinite()) {
    return ::testing::AssertionSuccess();
  }
  text << "relative difference " << difference << " exceeds " << tolerance << "\nactual\n"
       << a << "\nexpected\n"
       << b;
  return ::testing::AssertionFailure() << text.str();
}

}  // namespace chasles::test
