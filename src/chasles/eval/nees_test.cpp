#include <limits>

#include <Eigen/Cholesky>

#include <chasles/base/error.hpp>
#include <chasles/eval/nees.hpp>
#include <chasles/eval/test_trajectories.hpp>

namespace chasles {
namespace {

const std::vector<PoseError> kDefinitions = {PoseError::kStandard, PoseError::kBodyTwist,
                                             PoseError::kWorldTwist};

// A correlated covariance of [theta; dp], small enough for the errors to stay linear.
Matrix6d random_covariance(test::Random& random) {
  Matrix6d A;
  for (double& x : A.reshaped()) x = random.normal();
  Vector6d sigma;
  sigma << 1e-5, 2e-5, 1e-5, 0.01, 0.02, 0.03;
  return sigma.asDiagonal() * (A * A.transpose() + Matrix6d::Identity()) * sigma.asDiagonal();
}

struct Sampled {
  MatchedTrajectories matched;
  std::vector<Matrix6d> covariances;
};

// Estimates whose standard errors are drawn from the covariances; the first pose is exact.
Sampled sample(std::size_t n, std::uint64_t seed) {
  test::Random random(seed);
  const Trajectory truth = test::moved(test::some_transform(), test::helix(n));
  Trajectory estimate = test::helix(n);
  Sampled result;
  result.covariances.emplace_back(Matrix6d::Zero());
  for (std::size_t i = 1; i < n; ++i) {
    const Matrix6d P = random_covariance(random);
    const Vector6d e = P.llt().matrixL() * random.normal_vector(6);
    SE3& pose = estimate[i].pose;
    pose = {so3::exp(-e.head<3>()) * pose.R, pose.p - e.tail<3>()};
    result.covariances.push_back(P);
  }
  result.matched = associate(estimate, truth);
  return result;
}

TEST(PoseErrors, AreWhatTheirNamesSay) {
  test::Random random(51);
  const SE3 estimate{so3::exp(random.normal_vector(3)), 9 * random.normal_vector(3)};
  const Vector6d xi = random.normal_vector(6);
  EXPECT_TRUE(
      test::agree(pose_error(PoseError::kBodyTwist, estimate * se3::exp(xi), estimate), xi, 1e-13));
  EXPECT_TRUE(test::agree(pose_error(PoseError::kWorldTwist, se3::exp(xi) * estimate, estimate), xi,
                          1e-13));
  const SE3 standard{so3::exp(xi.head<3>()) * estimate.R, estimate.p + xi.tail<3>()};
  EXPECT_TRUE(test::agree(pose_error(PoseError::kStandard, standard, estimate), xi, 1e-13));
}

TEST(PoseErrors, TheMapIsTheDerivativeByTheStandardError) {
  test::Random random(52);
  for (int i = 0; i < 10; ++i) {
    const SE3 estimate{so3::exp(random.normal_vector(3)), 9 * random.normal_vector(3)};
    for (const PoseError definition : kDefinitions) {
      const auto error = [&](const Vector6d& e) {
        const SE3 truth{so3::exp(e.head<3>()) * estimate.R, estimate.p + e.tail<3>()};
        return pose_error(definition, truth, estimate);
      };
      const Vector6d zero = Vector6d::Zero();
      EXPECT_TRUE(test::agree(pose_error_map(definition, estimate),
                              test::numeric_derivative(error, zero), 1e-11))
          << name(definition);
    }
  }
}

TEST(Nees, OfErrorsDrawnFromTheirCovarianceIsTheirDegreesOfFreedom) {
  const Sampled sampled = sample(2000, 53);
  for (const PoseError definition : kDefinitions) {
    const Nees result = nees(sampled.matched, sampled.covariances, definition);
    for (const ConsistencySummary* s :
         {&result.position_summary, &result.attitude_summary, &result.pose_summary}) {
      EXPECT_TRUE(s->band.contains(s->mean)) << name(definition) << " " << s->dof << " " << s->mean;
      EXPECT_NEAR(s->inside, 0.95, 4 * std::sqrt(0.95 * 0.05 / 2000));
      EXPECT_EQ(s->count, 1999U);
      EXPECT_EQ(s->skipped, 1U);
    }
    EXPECT_NEAR(result.pose_summary.median, chi2_quantile(0.5, 6), 0.4);
  }
}

TEST(Nees, OfTheWholePoseIsTheSameInAllCoordinatesForSmallErrors) {
  const Sampled sampled = sample(50, 54);
  const Nees standard = nees(sampled.matched, sampled.covariances);
  for (const PoseError definition : {PoseError::kBodyTwist, PoseError::kWorldTwist}) {
    const Nees other = nees(sampled.matched, sampled.covariances, definition);
    for (std::size_t i = 1; i < other.pose.size(); ++i) {
      EXPECT_NEAR(other.pose[i] / standard.pose[i], 1, 5e-3);
    }
    EXPECT_NEAR(other.attitude_summary.mean / standard.attitude_summary.mean, 1, 1e-9);
  }
}

TEST(Nees, OfTheWorldTwistMixesTheLeverArmIntoThePosition) {
  const Sampled sampled = sample(200, 55);
  const Nees standard = nees(sampled.matched, sampled.covariances);
  const Nees world = nees(sampled.matched, sampled.covariances, PoseError::kWorldTwist);
  EXPECT_GT(std::abs(world.position[100] / standard.position[100] - 1), 1e-6);
}

TEST(Nees, GrowsWithTheSquareOfAnOverconfidentSigma) {
  Sampled sampled = sample(500, 56);
  const double before = nees(sampled.matched, sampled.covariances).pose_summary.mean;
  for (Matrix6d& P : sampled.covariances) P /= 9;
  const ConsistencySummary after = nees(sampled.matched, sampled.covariances).pose_summary;
  EXPECT_NEAR(after.mean / before, 9, 1e-9);
  EXPECT_FALSE(after.band.contains(after.mean));
}

TEST(Nees, SkipsSingularCovariancesAndCountsThem) {
  Sampled sampled = sample(20, 57);
  sampled.covariances[3].setZero();
  sampled.covariances[4](2, 2) = std::numeric_limits<double>::quiet_NaN();
  sampled.covariances[5] = Vector6d::Ones() * Vector6d::Ones().transpose();
  sampled.covariances[6].row(0).setZero();
  sampled.covariances[6].col(0).setZero();
  const Nees result = nees(sampled.matched, sampled.covariances);
  EXPECT_EQ(result.pose_summary.skipped, 5U);
  EXPECT_EQ(result.pose_summary.count, 15U);
  EXPECT_EQ(result.position_summary.skipped, 4U);
  EXPECT_TRUE(std::isnan(result.pose[5]));
}

TEST(Nees, WithoutAnyRegularCovarianceHasNoMean) {
  Sampled sampled = sample(10, 58);
  for (Matrix6d& P : sampled.covariances) P.setZero();
  const Nees result = nees(sampled.matched, sampled.covariances);
  EXPECT_EQ(result.pose_summary.count, 0U);
  EXPECT_TRUE(std::isnan(result.pose_summary.mean));
  EXPECT_TRUE(std::isnan(result.pose_summary.inside));
}

TEST(Nees, TakesTheCovarianceOfTheMatchedRow) {
  Sampled sampled = sample(40, 59);
  const double whole = nees(sampled.matched, sampled.covariances).pose[30];
  MatchedTrajectories part = sampled.matched;
  part.estimate.erase(part.estimate.begin() + 5, part.estimate.begin() + 15);
  part.truth.erase(part.truth.begin() + 5, part.truth.begin() + 15);
  part.estimate_index.erase(part.estimate_index.begin() + 5, part.estimate_index.begin() + 15);
  EXPECT_DOUBLE_EQ(nees(part, sampled.covariances).pose[20], whole);
  sampled.covariances.resize(30);
  EXPECT_THROW(nees(part, sampled.covariances), InputError);
}

TEST(SigmaShares, CountErrorsWithinTheirOwnSigmas) {
  // The i-th error is i of its sigmas on axis 0, so 0 to 3 of 10 are inside.
  std::vector<Vector6d> errors;
  std::vector<Matrix6d> covariances;
  for (int i = 0; i < 10; ++i) {
    const Vector6d sigma = (1 + i) * Vector6d::Constant(0.1);
    covariances.emplace_back(sigma.cwiseAbs2().asDiagonal());
    errors.emplace_back(Vector6d::Zero());
    errors.back()[0] = (i % 2 == 0 ? 0.999 : -0.999) * i * sigma[0];
    errors.back()[5] = 3.001 * sigma[5];
  }
  covariances[9](3, 3) = 0;  // these do not count
  covariances[8](3, 3) = std::numeric_limits<double>::quiet_NaN();
  const SigmaShares shares = sigma_shares(errors, covariances);
  EXPECT_DOUBLE_EQ(shares.share[0], 0.4);
  EXPECT_DOUBLE_EQ(shares.share[1], 1);
  EXPECT_DOUBLE_EQ(shares.share[3], 1);
  EXPECT_DOUBLE_EQ(shares.share[5], 0);
  EXPECT_EQ(shares.count, (std::array<std::size_t, 6>{10, 10, 10, 8, 10, 10}));
  EXPECT_DOUBLE_EQ(sigma_shares(errors, covariances, 5).share[0], 0.6);
  EXPECT_TRUE(std::isnan(sigma_shares({}, {}).share[2]));
}

TEST(SigmaShares, OfNeesAreThoseOfItsErrorsInWorldAxes) {
  const Sampled sampled = sample(20000, 60);
  for (const PoseError definition : kDefinitions) {
    const SigmaShares shares =
        nees(sampled.matched, sampled.covariances, definition).within_3_sigma;
    for (std::size_t axis = 0; axis < 6; ++axis) {
      EXPECT_EQ(shares.count[axis], 19999U);
      EXPECT_NEAR(shares.share[axis], 0.9973, 4 * std::sqrt(0.9973 * 0.0027 / 20000));
      EXPECT_LT(shares.share[axis], 1);
    }
  }
  // A sigma too small by 3 leaves the share within one sigma: 0.6827.
  Sampled overconfident = sampled;
  for (Matrix6d& P : overconfident.covariances) P.row(4) /= 3, P.col(4) /= 3;
  const SigmaShares shares = nees(overconfident.matched, overconfident.covariances).within_3_sigma;
  EXPECT_NEAR(shares.share[4], 0.6827, 4 * std::sqrt(0.6827 * 0.3173 / 20000));
  EXPECT_GT(shares.share[3], 0.99);
}

}  // namespace
}  // namespace chasles
