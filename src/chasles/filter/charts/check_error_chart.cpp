#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include <chasles/base/error.hpp>
#include <chasles/filter/charts/registered_charts.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Numbers in [-1, 1] without structure: fractions of multiples of the golden ratio.
class Scattered {
 public:
  double next() {
    at_ = std::fmod(at_ + 0.6180339887498949, 1);
    return 2 * at_ - 1;
  }
  Vector3d vector(double size) {
    const double x = next(), y = next(), z = next();
    return size * Vector3d(x, y, z);
  }
  VectorXd vector(Eigen::Index n, double size) {
    VectorXd v(n);
    for (double& value : v) value = size * next();
    return v;
  }

 private:
  double at_ = 0.5;
};

State state_to_check(Scattered& numbers, bool velocity) {
  State x;
  x.world_T_imu = {so3::exp(numbers.vector(1)), numbers.vector(5)};
  x.additive = numbers.vector(6, 0.1);
  if (velocity) x.v_world = numbers.vector(2);
  int row = x.core_size();
  x.clones.push_back({.id = 1,
                      .time = {},
                      .world_T_imu = {so3::exp(numbers.vector(1)), numbers.vector(5)},
                      .row = row});
  row += 6;
  for (int i = 0; i < 3; ++i, row += 3) {
    x.landmarks.push_back({.id = i, .p_world = numbers.vector(5), .row = row, .observations = 1});
  }
  x.landmarks.back().anchor = 1;
  x.landmarks.back().inverse_depth = Vector3d(0.1, 0.2, 0.3) + numbers.vector(0.1);
  return x;
}

double largest_difference(const SE3& x, const SE3& y) {
  return std::max((x.R - y.R).cwiseAbs().maxCoeff(), (x.p - y.p).cwiseAbs().maxCoeff());
}

double largest_difference(const State& x, const State& y) {
  double d = std::max(largest_difference(x.world_T_imu, y.world_T_imu),
                      (x.additive - y.additive).cwiseAbs().maxCoeff());
  if (x.v_world) d = std::max(d, (*x.v_world - *y.v_world).cwiseAbs().maxCoeff());
  for (std::size_t i = 0; i < x.clones.size(); ++i) {
    d = std::max(d, largest_difference(x.clones[i].world_T_imu, y.clones[i].world_T_imu));
  }
  for (std::size_t i = 0; i < x.landmarks.size(); ++i) {
    d = std::max(d,
                 (x.landmarks[i].parameters() - y.landmarks[i].parameters()).cwiseAbs().maxCoeff());
  }
  return d;
}

// True also of what is not a number.
bool exceeds(double difference, double tolerance) { return !(difference <= tolerance); }

void expect_small(const ErrorChart& chart, const std::string& fact, double difference,
                  double tolerance) {
  if (!exceeds(difference, tolerance)) return;
  std::ostringstream text;
  text << "error chart '" << chart.name << "': expected " << fact << ", but they differ by "
       << difference << " (at most " << tolerance << ")";
  throw UsageError(text.str());
}

void check_local(const ErrorChart& chart, const State& x, const VectorXd& xi) {
  State y = x;
  retract(chart, y, xi);
  const Eigen::Index rows = chart.local(x, y).size();
  if (rows != xi.size()) {
    throw UsageError("error chart '" + std::string(chart.name) + "': local() has " +
                     std::to_string(rows) + " numbers, expected " + std::to_string(xi.size()) +
                     ", one for each row of the state");
  }
  const VectorXd found = local(chart, x, y);
  expect_small(chart, "local(x, retract(x, xi)) = xi", (found - xi).cwiseAbs().maxCoeff(), 1e-8);
}

// T, as motion_block and landmark_block have it, against central differences.
void check_derivative(const ErrorChart& chart, const State& x) {
  constexpr double kStep = 1e-5;
  const int n = x.size();
  MatrixXd T = MatrixXd::Identity(n, n);
  push(chart, x, T);
  for (int j = 0; j < n; ++j) {
    State forth = x, back = x;
    retract(kStandardChart, forth, VectorXd(kStep * VectorXd::Unit(n, j)));
    retract(kStandardChart, back, VectorXd(-kStep * VectorXd::Unit(n, j)));
    const VectorXd d = (local(chart, x, forth) - local(chart, x, back)) / (2 * kStep);
    Eigen::Index row = 0;
    const double difference = (T.col(j) - d).cwiseAbs().maxCoeff(&row);
    expect_small(chart,
                 "motion_block and landmark_block to be the derivative of local() by the reference "
                 "errors (row " +
                     std::to_string(row) + ", column " + std::to_string(j) + ")",
                 difference, 1e-6);
  }
}

}  // namespace

void check_error_chart(const ErrorChart& chart) {
  Scattered numbers;
  for (const bool velocity : {false, true}) {
    const State x = state_to_check(numbers, velocity);
    State same = x;
    retract(chart, same, VectorXd::Zero(x.size()));
    expect_small(chart, "retract(x, 0) = x", largest_difference(same, x), 1e-12);
    for (const double size : {0.01, 0.5}) check_local(chart, x, numbers.vector(x.size(), size));
    check_derivative(chart, x);
    if (!chart.landmark_block) continue;
    const Eigen::Matrix<double, 3, 9> rotation = chart.motion_block(x).topRows<3>();
    expect_small(chart, "the rotation's rows of motion_block to be those of the identity",
                 (rotation - Eigen::Matrix<double, 3, 9>::Identity()).cwiseAbs().maxCoeff(), 0);
  }
}

}  // namespace chasles
