#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include <chasles/lie/series.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

Eigen::MatrixXd random_matrix(test::Random& random, Eigen::Index rows, Eigen::Index columns) {
  return random.normal_vector(rows * columns).reshaped(rows, columns);
}

// Eigenvalues of both signs.
Eigen::MatrixXd random_symmetric(test::Random& random, Eigen::Index n) {
  const Eigen::MatrixXd M = random_matrix(random, n, n);
  return M + M.transpose();
}

// By the inverse in extended precision; what a condition of 1e4 costs is allowed.
constexpr double kTolerance = 1e-11;

TEST(SmallMatrices, AreSolvedInAllSizes) {
  test::Random random(1);
  for (int n = 1; n <= kMostSmallRows; ++n) {
    const Eigen::MatrixXd A = random_symmetric(random, n), G = random_matrix(random, n, n);
    const Eigen::MatrixXd B = random_matrix(random, n, n + 2);
    Eigen::MatrixXd X = B, Y = B;
    small::solve_symmetric(A, X);
    small::solve(G, Y);
    EXPECT_LT((X - test::inverse(A) * B).norm(), kTolerance * (1 + X.norm())) << n;
    EXPECT_LT((Y - test::inverse(G) * B).norm(), kTolerance * (1 + Y.norm())) << n;
    EXPECT_LT((small::inverse_symmetric(A) * A - Eigen::MatrixXd::Identity(n, n)).norm(), 1e-9)
        << n;
    EXPECT_LT((small::inverse(G) * G - Eigen::MatrixXd::Identity(n, n)).norm(), 1e-9) << n;
  }
}

TEST(SmallMatrices, AreSolvedAndInvertedByTheirFixedSize) {
  test::Random random(2);
  const Eigen::Matrix<double, 5, 5> A = random_symmetric(random, 5),
                                    G = random_matrix(random, 5, 5);
  const Eigen::Matrix<double, 5, 1> b = random.normal_vector(5);
  EXPECT_LT((A * solve_symmetric(A, b) - b).norm(), kTolerance);
  EXPECT_LT((G * solve(G, b) - b).norm(), kTolerance);
  EXPECT_LT((inverse_symmetric(A) - test::inverse(A)).norm(), kTolerance);
  EXPECT_LT((inverse(G) - test::inverse(G)).norm(), kTolerance);
}

TEST(SmallMatrices, OnlyTheLowerTriangleOfASymmetricOneIsRead) {
  test::Random random(3);
  const Eigen::Matrix<double, 6, 6> A = random_symmetric(random, 6);
  const Eigen::Matrix<double, 6, 6> lower = A.triangularView<Eigen::Lower>();
  EXPECT_EQ(inverse_symmetric(lower), inverse_symmetric(A));
  EXPECT_EQ(symmetric_eigen(lower).values, symmetric_eigen(A).values);
}

TEST(SmallMatrices, WhatASingularOneDoesNotDetermineIsZero) {
  const Eigen::Vector3d diagonal(4, 0, 2);
  const Eigen::Matrix3d A = diagonal.asDiagonal();
  EXPECT_EQ(solve_symmetric(A, Eigen::Vector3d(1, 1, 1)), Eigen::Vector3d(0.25, 0, 0.5));
  EXPECT_FALSE(inverse(A).allFinite());
}

TEST(SmallMatrices, NotANumberStaysOne) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Identity();
  A(1, 1) = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector3d b(1, 1, 1);
  EXPECT_FALSE(solve_symmetric(A, b).allFinite());
  EXPECT_FALSE(solve(A, b).allFinite());
  EXPECT_FALSE(whitening_of(A));
  const SymmetricEigen eigen = symmetric_eigen(A);
  EXPECT_TRUE(eigen.values.array().isNaN().all() && eigen.vectors.array().isNaN().all());
}

TEST(SmallMatrices, RejectMoreThanTheirRows) {
  const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(kMostSmallRows + 1, kMostSmallRows + 1);
  Eigen::MatrixXd X = A;
  EXPECT_THROW(small::solve_symmetric(A, X), std::invalid_argument);
  EXPECT_THROW(small::solve(A, X), std::invalid_argument);
  EXPECT_THROW(small::congruence(A, A, X), std::invalid_argument);
}

TEST(SmallMatrices, CongruenceIsTheProductOfThree) {
  test::Random random(4);
  const Eigen::Matrix<double, 3, 9> T = random_matrix(random, 3, 9);
  const Eigen::Matrix<double, 9, 9> P = random_symmetric(random, 9);
  EXPECT_LT((congruence(T, P) - T * P * T.transpose()).norm(), kTolerance);
}

TEST(SmallMatrices, EigenvaluesRiseAndVectorsBelongToThem) {
  test::Random random(5);
  const Eigen::MatrixXd A = random_symmetric(random, 20);
  const SymmetricEigen eigen = symmetric_eigen(A);
  for (int i = 1; i < 20; ++i) EXPECT_LE(eigen.values[i - 1], eigen.values[i]);
  EXPECT_LT((A * eigen.vectors - eigen.vectors * eigen.values.asDiagonal()).norm(), kTolerance);
  EXPECT_LT((eigen.vectors.transpose() * eigen.vectors - Eigen::MatrixXd::Identity(20, 20)).norm(),
            kTolerance);
}

TEST(SmallMatrices, AWhiteningMakesACovarianceOneWhateverItsUnits) {
  test::Random random(6);
  const Eigen::MatrixXd M = random_matrix(random, 20, 20);
  Eigen::VectorXd units(20);
  for (double& unit : units) unit = std::pow(10, random.uniform(-6, 6));
  const Eigen::MatrixXd P = units.asDiagonal() * (M * M.transpose()) * units.asDiagonal();
  const std::optional<Eigen::MatrixXd> W = whitening_of(P);
  ASSERT_TRUE(W);
  EXPECT_TRUE(W->isLowerTriangular(0));
  EXPECT_LT((*W * P * W->transpose() - Eigen::MatrixXd::Identity(20, 20)).norm(), 1e-9);
  EXPECT_FALSE(whitening_of(random_symmetric(random, 4)));
}

}  // namespace
}  // namespace chasles
