#include <cmath>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/pair_difference.hpp>
#include <chasles/eval/test_trajectories.hpp>

namespace chasles {
namespace {

// A correlated covariance of [theta; dp], small enough for the errors to stay linear.
Matrix6d some_covariance(test::Random& random) {
  Matrix6d A;
  for (double& x : A.reshaped()) x = random.normal();
  Vector6d sigma;
  sigma << 1e-5, 2e-5, 1e-5, 0.01, 0.02, 0.03;
  return sigma.asDiagonal() * (A * A.transpose() + Matrix6d::Identity()) * sigma.asDiagonal();
}

// Of a helix, in a world of its own. Standard errors with these covariances, the first pose is
// exact.
EstimatedPath estimate_of(const SE3& own_T_world, std::size_t n, std::uint64_t seed) {
  test::Random random(seed);
  EstimatedPath path{.poses = test::moved(own_T_world, test::helix(n)), .covariances = {}};
  path.covariances.emplace_back(Matrix6d::Zero());
  for (std::size_t i = 1; i < n; ++i) {
    const Matrix6d P = some_covariance(random);
    const Vector6d e = P.llt().matrixL() * random.normal_vector(6);
    SE3& pose = path.poses[i].pose;
    pose = {so3::exp(-e.head<3>()) * pose.R, pose.p - e.tail<3>()};
    path.covariances.push_back(P);
  }
  return path;
}

TEST(PairDifference, OfIndependentEstimatesIsChiSquare) {
  constexpr std::size_t kPoses = 3000;
  const EstimatedPath a = estimate_of({}, kPoses, 1),
                      b = estimate_of(test::some_transform(), kPoses, 2);
  const PairDifference d = pair_difference(a, b, false);
  EXPECT_EQ(d.compared, kPoses);
  EXPECT_EQ(d.pose.count, kPoses - 1) << "the first pose has no variance";
  EXPECT_TRUE(d.position.band.contains(d.position.mean)) << d.position.mean;
  EXPECT_TRUE(d.attitude.band.contains(d.attitude.mean)) << d.attitude.mean;
  EXPECT_TRUE(d.pose.band.contains(d.pose.mean)) << d.pose.mean;
  EXPECT_NEAR(d.factor(), 1, 0.03);
  EXPECT_NEAR(d.pose.inside, 0.95, 0.02);
}

TEST(PairDifference, FindsTheFactorOfSigmasThatAreTooSmall) {
  EstimatedPath a = estimate_of({}, 3000, 3), b = estimate_of(test::some_transform(), 3000, 4);
  for (EstimatedPath* path : {&a, &b}) {
    for (Matrix6d& P : path->covariances) P /= 4;
  }
  EXPECT_NEAR(pair_difference(a, b, false).factor(), 2, 0.06);
}

// Errors that both have, and count in both covariances, make the difference smaller, never larger.
TEST(PairDifference, IsALowerBoundWhereErrorsAreShared) {
  test::Random random(5);
  EstimatedPath a = estimate_of({}, 2000, 6), b = estimate_of({}, 2000, 7);
  for (std::size_t i = 1; i < a.poses.size(); ++i) {
    const Eigen::Vector3d shared = 0.05 * random.normal_vector(3);
    for (EstimatedPath* path : {&a, &b}) {
      path->poses[i].pose.p += shared;
      path->covariances[i].bottomRightCorner<3, 3>() += 0.05 * 0.05 * Eigen::Matrix3d::Identity();
    }
  }
  const PairDifference d = pair_difference(a, b, false);
  EXPECT_LT(d.position.mean, d.position.band.low);
  EXPECT_LT(d.factor(), 1);
}

// The covariance of the second is stated in the axes of its own world, here turned by 90 degrees.
TEST(PairDifference, TurnsTheCovarianceOfTheSecondIntoTheWorldOfTheFirst) {
  const SE3 turn{so3::exp({0, 0, 0.5 * 3.14159265358979}), Eigen::Vector3d(1, 2, 0)};
  EstimatedPath a{.poses = test::helix(50), .covariances = {}},
      b{.poses = test::moved(turn, test::helix(50)), .covariances = {}};
  Vector6d variances;
  variances << 1e-6, 1e-6, 1e-6, 0.04, 1e-4, 1e-4;  // along x of the second's world
  for (std::size_t i = 0; i < 50; ++i) {
    a.covariances.emplace_back(1e-12 * Matrix6d::Identity());
    b.covariances.emplace_back(variances.asDiagonal());
    if (i > 0) b.poses[i].pose.p.x() += 0.2;  // one sigma
  }
  const PairDifference d = pair_difference(a, b, true);
  EXPECT_NEAR(d.position.median, 1, 1e-6);
  EXPECT_NEAR(d.position_rms_m, 0.2 * std::sqrt(49.0 / 50), 1e-9);
}

TEST(PairDifference, RejectsEqualEstimatesAndMissingCovariances) {
  EstimatedPath a = estimate_of({}, 100, 8);
  EXPECT_THROW(pair_difference(a, a, false), InputError);
  const EstimatedPath b = estimate_of({}, 100, 9);
  EstimatedPath certain = a, sure = b;
  for (Matrix6d& P : certain.covariances) P.setZero();
  for (Matrix6d& P : sure.covariances) P.setZero();
  EXPECT_THROW(pair_difference(certain, sure, false), InputError);
  a.covariances.pop_back();
  EXPECT_THROW(pair_difference(a, b, false), InputError);
  EXPECT_THROW(pair_difference(b, a, false), InputError);
}

}  // namespace
}  // namespace chasles
