#include <numeric>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/filter/random_ekf_testing.hpp>
#include <chasles/loop/joint_covariance.hpp>
#include <chasles/loop/map_testing.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;

constexpr JointCovariance::Limits kAll{.error = 0, .rank = 1000};

// Points along a path whose errors are a random walk, with their own errors beside it.
MatrixXd drifting(int points, double own) {
  const Index n = 3 * points;
  MatrixXd P(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      const bool same_axis = i % 3 == j % 3;
      P(i, j) = same_axis ? 1e-4 * static_cast<double>(std::min(i, j) / 3 + 1) : 0;
    }
  }
  P.diagonal().array() += own * own;
  return P;
}

double largest_correlation_error(const MatrixXd& P, const MatrixXd& Q) {
  const Eigen::VectorXd sigma = P.diagonal().cwiseSqrt();
  return (P - Q).cwiseQuotient(sigma * sigma.transpose()).cwiseAbs().maxCoeff();
}

TEST(JointCovariance, AFewSharedDirectionsAreFoundExactly) {
  test::Random random(1);
  const MatrixXd U = test::random_matrix(random, 60, 4);
  MatrixXd P = U * U.transpose();
  for (Index i = 0; i < 60; i += 3) P.block<3, 3>(i, i) += test::random_covariance(random, 3, 1e-3);
  // The own errors are small, so that the directions of the whole are those of U, nearly.
  const JointCovariance whole = JointCovariance::of_matrix(P, kAll);
  EXPECT_LT(largest_correlation_error(P, test::whole_covariance(whole)), 1e-12);
  const JointCovariance few = JointCovariance::of_matrix(P, {.error = 1e-4, .rank = 48});
  EXPECT_EQ(few.rank(), 4);
  EXPECT_LT(largest_correlation_error(P, test::whole_covariance(few)), 1e-3);
}

TEST(JointCovariance, ADriftNeedsFewDirectionsAndPointsStayExact) {
  const MatrixXd P = drifting(300, 0.02);
  const JointCovariance::Limits limits{.error = 0.003, .rank = 60};
  const JointCovariance compressed = JointCovariance::of_matrix(P, limits);
  EXPECT_LT(compressed.rank(), limits.rank);
  EXPECT_GT(compressed.rank(), 3);
  const MatrixXd Q = test::whole_covariance(compressed);
  const Eigen::VectorXd sigma = P.diagonal().cwiseSqrt();
  const MatrixXd error = (P - Q).cwiseQuotient(sigma * sigma.transpose());
  EXPECT_LE(std::sqrt(error.squaredNorm() / static_cast<double>(error.size())), limits.error);
  for (Index i = 0; i < P.rows(); i += 3) {
    EXPECT_TRUE(test::agree(P.block<3, 3>(i, i), Q.block<3, 3>(i, i), 1e-12, 0));
    EXPECT_TRUE(test::agree(compressed.of(static_cast<int>(i / 3)), P.block<3, 3>(i, i), 1e-12, 0));
  }
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<MatrixXd>(Q).eigenvalues().minCoeff(), 0);
}

TEST(JointCovariance, ReducedIsTheSameWithFewerDirections) {
  const JointCovariance all = JointCovariance::of_matrix(drifting(100, 0.01), kAll);
  const JointCovariance::Limits limits{.error = 0.002, .rank = 70};
  const JointCovariance few = all.reduced(limits);
  EXPECT_LT(few.rank(), limits.rank);
  const MatrixXd P = test::whole_covariance(all), Q = test::whole_covariance(few);
  const Eigen::VectorXd sigma = P.diagonal().cwiseSqrt();
  const MatrixXd error = (P - Q).cwiseQuotient(sigma * sigma.transpose());
  EXPECT_LE(std::sqrt(error.squaredNorm() / static_cast<double>(error.size())), limits.error);
  EXPECT_GT(few.rank(), 3);
  for (int i = 0; i < all.points(); ++i) {
    EXPECT_TRUE(test::agree(all.of(i), few.of(i), 1e-12, 0)) << i;
  }
  EXPECT_EQ(all.reduced({.error = 1e9, .rank = 10}).rank(), 0);
}

TEST(JointCovariance, WhatIsExactStaysExact) {
  test::Random random(3);
  MatrixXd P = MatrixXd::Zero(12, 12);
  P.bottomRightCorner(6, 6) = test::random_covariance(random, 6, 1);
  P.row(8).setZero();  // and a point that is known along one axis
  P.col(8).setZero();
  const MatrixXd Q = test::whole_covariance(JointCovariance::of_matrix(P, kAll));
  EXPECT_TRUE(test::agree(P, Q, 1e-12, 1e-14));
  EXPECT_EQ(JointCovariance::of_matrix(MatrixXd(0, 0), {}).points(), 0);
}

TEST(JointCovariance, PartsAndSizes) {
  const JointCovariance all = JointCovariance::of_matrix(drifting(10, 0.01), kAll);
  const std::vector<int> some{7, 2};
  const MatrixXd P = test::whole_covariance(all), Q = all.of(some);
  EXPECT_TRUE(test::agree(Q.topRightCorner(3, 3), P.block<3, 3>(21, 6), 1e-12, 0));
  EXPECT_THROW(JointCovariance({Matrix3d::Identity()}, MatrixXd::Zero(4, 2)), UsageError);
  EXPECT_THROW(JointCovariance::of_matrix(MatrixXd::Zero(4, 4), {}), UsageError);
}

TEST(SharedPart, SplitsAJointCovarianceByWhatIsShared) {
  test::Random random(4);
  const MatrixXd P = test::random_covariance(random, 5 + 12, 1);
  const SharedPart part =
      shared_part(P.topLeftCorner(5, 5), P.bottomLeftCorner(12, 5), P.bottomRightCorner(12, 12));
  EXPECT_TRUE(test::agree(part.root * part.root.transpose(), P.topLeftCorner(5, 5), 1e-10, 0));
  EXPECT_TRUE(test::agree(part.others.shared().leftCols(5) * part.root.transpose(),
                          P.bottomLeftCorner(12, 5), 1e-10, 0));
  // Four points have at most twelve directions, so nothing is left out.
  EXPECT_TRUE(
      test::agree(test::whole_covariance(part.others), P.bottomRightCorner(12, 12), 0.02, 0));
  const SharedPart none = shared_part(MatrixXd(0, 0), MatrixXd(12, 0), P.bottomRightCorner(12, 12));
  EXPECT_EQ(none.root.size(), 0);
}

}  // namespace
}  // namespace chasles
