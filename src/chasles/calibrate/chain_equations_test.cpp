#include <random>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <chasles/calibrate/chain_equations.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The same problem as equations of a chain and as one dense matrix.
struct BothProblems {
  static constexpr Eigen::Index kSize = 3, kBorder = 4;
  static constexpr std::size_t kBlocks = 5;
  ChainEquations chain{kBlocks, kSize, kBorder};
  MatrixXd J = MatrixXd::Zero(0, kSize* kBlocks + kBorder);
  VectorXd r = VectorXd::Zero(0);

  explicit BothProblems(bool linked) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    const auto noise = [&](Eigen::Index rows, Eigen::Index cols) {
      return MatrixXd(MatrixXd::NullaryExpr(rows, cols, [&] { return normal(random); }));
    };
    const auto append = [&](Eigen::Index rows) {
      J.conservativeResizeLike(MatrixXd::Zero(J.rows() + rows, J.cols()));
      r.conservativeResize(r.size() + rows);
    };
    const std::vector<int> columns = {2, 0};
    for (std::size_t k = 0; k < kBlocks; ++k) {
      const MatrixXd a = noise(6, kSize), b = noise(6, 2);
      const VectorXd of_block = noise(6, 1);
      chain.add(k, a, b, columns, of_block);
      append(6);
      J.block(J.rows() - 6, kSize * static_cast<Eigen::Index>(k), 6, kSize) = a;
      J.block(J.rows() - 6, kSize * kBlocks + 2, 6, 1) = b.col(0);
      J.block(J.rows() - 6, kSize * kBlocks + 0, 6, 1) = b.col(1);
      r.tail(6) = of_block;
    }
    for (std::size_t k = 0; linked && k + 1 < kBlocks; ++k) {
      const MatrixXd a = noise(3, kSize), n = noise(3, kSize), b = noise(3, 1);
      const VectorXd of_link = noise(3, 1);
      const std::vector<int> third = {3};
      chain.add_link(k, a, n, b, third, of_link);
      append(3);
      J.block(J.rows() - 3, kSize * static_cast<Eigen::Index>(k), 3, kSize) = a;
      J.block(J.rows() - 3, kSize * static_cast<Eigen::Index>(k + 1), 3, kSize) = n;
      J.block(J.rows() - 3, kSize * kBlocks + 3, 3, 1) = b;
      r.tail(3) = of_link;
    }
    const MatrixXd b = noise(5, kBorder);
    const VectorXd of_border = noise(5, 1);
    const std::vector<int> all = {0, 1, 2, 3};
    chain.add_border(b, all, of_border);
    append(5);
    J.bottomRightCorner(5, kBorder) = b;
    r.tail(5) = of_border;
  }
};

TEST(ChainEquations, SolveAsTheDenseProblem) {
  for (const bool linked : {false, true}) {
    const BothProblems both(linked);
    for (const double damping : {0.0, 0.3}) {
      MatrixXd H = both.J.transpose() * both.J;
      H.diagonal() *= 1 + damping;
      const VectorXd g = both.J.transpose() * both.r, expected = -H.ldlt().solve(g);
      const auto step = both.chain.solve(damping);
      ASSERT_TRUE(step);
      VectorXd found(expected.size());
      for (std::size_t k = 0; k < BothProblems::kBlocks; ++k) {
        found.segment<BothProblems::kSize>(BothProblems::kSize * static_cast<Eigen::Index>(k)) =
            step->blocks[k];
      }
      found.tail<BothProblems::kBorder>() = step->border;
      EXPECT_LT((found - expected).norm(), 1e-12);
      const double before = both.r.squaredNorm() / 2,
                   after = (both.r + both.J * expected).squaredNorm() / 2;
      EXPECT_NEAR(step->decrease, before - after, 1e-12);
    }
    const MatrixXd covariance =
        MatrixXd((both.J.transpose() * both.J).inverse())
            .bottomRightCorner(BothProblems::kBorder, BothProblems::kBorder);
    const auto information = both.chain.border_information();
    ASSERT_TRUE(information);
    EXPECT_LT((*information * covariance - MatrixXd::Identity(4, 4)).norm(), 1e-10);
  }
}

TEST(ChainEquations, GradientsOfTheBlocksAddUpToThatOfTheBorder) {
  const BothProblems both(false);
  const auto gradients = both.chain.border_gradients();
  ASSERT_TRUE(gradients);
  const auto step = both.chain.solve(0);
  ASSERT_TRUE(step);
  // What the border's own residuals add is not of a block.
  const MatrixXd B = both.J.bottomRightCorner(5, 4);
  const VectorXd whole = gradients->rowwise().sum() + B.transpose() * both.r.tail(5);
  EXPECT_LT((whole + *both.chain.border_information() * step->border).norm(), 1e-10);
}

TEST(ChainEquations, WhatIsNotDeterminedHasNoSolution) {
  ChainEquations chain(1, 2, 1);
  const std::vector<int> columns = {0};
  chain.add(0, MatrixXd::Ones(3, 2), MatrixXd::Ones(3, 1), columns, VectorXd::Ones(3));
  EXPECT_FALSE(chain.solve(0));
}

}  // namespace
}  // namespace chasles
