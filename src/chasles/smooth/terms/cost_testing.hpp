#pragma once

#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/filter/testing.hpp>
#include <chasles/smooth/terms/cost_functions_detail.hpp>

// Cost functions as Ceres uses them, for tests: their derivatives by a chart's errors.
namespace chasles::test {

using namespace smooth_detail;

/// The blocks that a cost function depends on, and how their errors move them.
struct Blocks {
  const ErrorChart* chart;
  std::vector<std::vector<double>> numbers;
  /// The numbers of the first that is no motion, and of the first after these.
  std::optional<std::size_t> plain_from = {}, plain_until = {};

  bool is_motion(std::size_t block) const {
    const bool after = plain_until && block >= *plain_until;
    if (plain_from && block >= *plain_from && !after) return false;
    return numbers[block].size() == kMotionNumbers || numbers[block].size() == kPoseNumbers;
  }
  ChartManifold manifold(std::size_t block) const {
    return ChartManifold(*chart, numbers[block].size() == kMotionNumbers);
  }
  int errors(std::size_t block) const {
    return is_motion(block) ? manifold(block).TangentSize()
                            : static_cast<int>(numbers[block].size());
  }
  Blocks moved(std::size_t block, const Eigen::VectorXd& e) const {
    Blocks result = *this;
    std::vector<double>& x = result.numbers[block];
    if (is_motion(block)) {
      manifold(block).Plus(numbers[block].data(), e.data(), x.data());
    } else {
      for (std::size_t i = 0; i < x.size(); ++i) x[i] += e[static_cast<Eigen::Index>(i)];
    }
    return result;
  }
};

inline Eigen::VectorXd residual(const ceres::CostFunction& cost, const Blocks& blocks) {
  std::vector<const double*> x;
  for (const auto& numbers : blocks.numbers) x.push_back(numbers.data());
  Eigen::VectorXd r(cost.num_residuals());
  cost.Evaluate(x.data(), r.data(), nullptr);
  return r;
}

// Analytic, by the chart's errors: as Ceres multiplies them.
inline std::vector<Eigen::MatrixXd> jacobians(const ceres::CostFunction& cost,
                                              const Blocks& blocks) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<const double*> x;
  std::vector<RowMajor> J;
  for (const auto& numbers : blocks.numbers) {
    x.push_back(numbers.data());
    J.emplace_back(cost.num_residuals(), static_cast<Eigen::Index>(numbers.size()));
  }
  std::vector<double*> into;
  for (RowMajor& j : J) into.push_back(j.data());
  Eigen::VectorXd r(cost.num_residuals());
  cost.Evaluate(x.data(), r.data(), into.data());
  EXPECT_EQ(r, residual(cost, blocks));
  std::vector<Eigen::MatrixXd> result;
  for (std::size_t i = 0; i < J.size(); ++i) {
    if (!blocks.is_motion(i)) {
      result.emplace_back(J[i]);
      continue;
    }
    RowMajor plus(std::ssize(blocks.numbers[i]), blocks.errors(i));
    blocks.manifold(i).PlusJacobian(x[i], plus.data());
    result.emplace_back(J[i] * plus);
  }
  return result;
}

inline void expect_numeric(const ceres::CostFunction& cost, const Blocks& blocks,
                           double tolerance) {
  const std::vector<Eigen::MatrixXd> J = jacobians(cost, blocks);
  for (std::size_t i = 0; i < J.size(); ++i) {
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(blocks.errors(i));
    const Eigen::MatrixXd numeric = numeric_derivative(
        [&](const Eigen::VectorXd& e) { return residual(cost, blocks.moved(i, e)); }, zero, 1e-4);
    EXPECT_TRUE(agree(J[i], numeric, tolerance)) << "by block " << i;
  }
}

}  // namespace chasles::test
