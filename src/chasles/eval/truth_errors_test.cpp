#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/truth_error_model.hpp>
#include <chasles/eval/truth_errors.hpp>
#include <chasles/eval/truth_walk_testing.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

constexpr double kBegin = 1, kEnd = 31, kRate = 20;

struct Simulated {
  Trajectory estimate, truth;
  std::vector<Matrix6d> covariances;
};

// A truth of 200 Hz with these errors of the walk at 20 Hz.
Trajectory truth_with(const Vector7d& constants) {
  const auto [time, body, world] = TruthConstants::from(constants);
  return test::sampled(200, 0, kEnd + 1, [=](double t) {
    return SE3{so3::exp(-world) * test::walk_at(t).R * so3::exp(-body), test::walk_at(t - time).p};
  });
}

// An estimate as an inertial filter has it: heading and position walk randomly from the first pose
// on, an error of heading turns what follows about that pose, and the tilt is a stationary process.
// The covariances are exact. `overconfident`: the errors are that many times too large.
Simulated simulate(std::uint64_t seed, const Vector7d& constants, double overconfident = 1) {
  test::Random random(seed);
  Simulated result{.estimate = test::sampled(kRate, kBegin, kEnd),
                   .truth = truth_with(constants),
                   .covariances = {}};
  constexpr double kTilt = 0.003, kStep = 1 / kRate;
  const double kept = std::exp(-kStep / 10);
  Vector6d noise;  // in a step
  noise << Eigen::Vector2d::Constant(kTilt * std::sqrt(1 - kept * kept)),
      std::sqrt(kStep) * Eigen::Vector4d(0.0025, 0.006, 0.006, 0.004);
  Matrix6d F = Matrix6d::Identity();
  F(0, 0) = F(1, 1) = kept;
  Matrix6d walk = Matrix6d::Zero();
  walk(0, 0) = walk(1, 1) = kTilt * kTilt;
  Vector6d error = Vector6d::Zero();
  error.head<2>() = kTilt * random.normal_vector(2);
  const Eigen::Vector3d begin = result.estimate.front().pose.p;
  for (std::size_t i = 0; i < result.estimate.size(); ++i) {
    if (i > 0) {
      error = F * error + noise.cwiseProduct(random.normal_vector(6));
      walk = F * walk * F.transpose();
      walk.diagonal() += noise.cwiseAbs2();
    }
    SE3& pose = result.estimate[i].pose;
    Matrix6d J = Matrix6d::Identity();
    J.block<3, 1>(3, 2) = Eigen::Vector3d::UnitZ().cross(pose.p - begin);
    const Vector6d e = overconfident * (J * error);
    result.covariances.emplace_back(J * walk * J.transpose());
    pose = {so3::exp(-e.head<3>()) * pose.R, pose.p - e.tail<3>()};
  }
  return result;
}

TruthErrors found(const Simulated& simulated) {
  return estimate_truth_errors(simulated.estimate, simulated.truth, simulated.covariances,
                               {.pairing = {}, .level = true, .priors = {}});
}

Vector7d some_constants() {
  Vector7d constants;
  constants << 0.012, 0.009, -0.007, 0.010, 0.005, -0.009, 0.026;
  return constants;
}

double square(const TruthErrors& errors, const Vector7d& expected) {
  return normalised_square(errors.value - expected, errors.covariance);
}

TEST(TruthErrors, OfAnExactEstimateAreThoseThatWereMade) {
  Simulated simulated = simulate(1, some_constants());
  simulated.estimate = test::sampled(kRate, kBegin, kEnd);
  for (Matrix6d& P : simulated.covariances) {
    P = Vector6d(1e-4 * Vector6d::Ones()).cwiseAbs2().asDiagonal();
  }
  const TruthErrors errors = found(simulated);
  // The position between stamps of the truth is on a line: 5 um.
  EXPECT_NEAR(errors.value[0], 0.012, 1e-4);
  EXPECT_TRUE(test::agree(errors.value, some_constants(), 2e-4));
  EXPECT_TRUE(errors.significant(TruthErrorKind::kPositionTime));
  EXPECT_TRUE(errors.significant(TruthErrorKind::kBodyRotation));
  EXPECT_TRUE(errors.significant(TruthErrorKind::kWorldRotation));
  EXPECT_LT(errors.rigid.position_m.rmse, 1e-4);
  EXPECT_LT(errors.rigid.attitude_deg.rmse, 0.01);
}

// Means over runs of NEES by its degrees of freedom.
struct Means {
  double before = 0;  ///< of the pose, as it is
  double position = 0, attitude = 0, pose = 0;
  double squares = 0;   ///< of the constants' errors
  int significant = 0;  ///< of three constants a run
};

Means over_runs(int runs, const Vector7d& constants, double overconfident = 1) {
  Means means;
  for (int k = 0; k < runs; ++k) {
    const Simulated one = simulate(100 + static_cast<std::uint64_t>(k), constants, overconfident);
    const TruthErrors errors = found(one);
    means.before +=
        nees(associate(one.estimate, one.truth), one.covariances, PoseError::kStandard, true)
            .pose_summary.mean /
        6 / runs;
    means.position += errors.nees.position_summary.mean / 3 / runs;
    means.attitude += errors.nees.attitude_summary.mean / 3 / runs;
    means.pose += errors.nees.pose_summary.mean / 6 / runs;
    means.squares += square(errors, constants) / runs;
    for (const auto kind : {TruthErrorKind::kPositionTime, TruthErrorKind::kBodyRotation,
                            TruthErrorKind::kWorldRotation}) {
      means.significant += errors.significant(kind) ? 1 : 0;
    }
  }
  return means;
}

// One run's NEES scatters by about half of its mean, because its errors are correlated.
TEST(TruthErrors, AnExactTruthKeepsItsNees) {
  const Means means = over_runs(100, Vector7d::Zero());
  EXPECT_NEAR(means.before, 1, 0.15);
  EXPECT_NEAR(means.pose, means.before, 0.1);
  EXPECT_NEAR(means.position, 1, 0.15);
  EXPECT_NEAR(means.attitude, 1, 0.3);
  EXPECT_LE(means.significant, 4) << "of 300, expected 0.3 %";
  EXPECT_LT(means.squares, chi2_band(7, 100, 0.999).high);
}

TEST(TruthErrors, OfATruthThatHasSomeAreRecoveredWithinTheirSigmas) {
  const Means means = over_runs(100, some_constants());
  EXPECT_GT(means.before, 8);
  EXPECT_NEAR(means.pose, 1, 0.15);
  EXPECT_NEAR(means.position, 1, 0.15);
  EXPECT_NEAR(means.attitude, 1, 0.3);
  EXPECT_GT(means.significant, 250) << "of 300";
  // Wider than right at most by a third, and not too narrow.
  EXPECT_LT(means.squares, chi2_band(7, 100, 0.999).high);
  EXPECT_GT(means.squares, 0.6 * 7);
}

// Seven constants do not explain the errors of an estimate whose covariances are too small.
TEST(TruthErrors, DoNotFlatterAnOverconfidentEstimate) {
  for (const Vector7d& constants : {Vector7d(Vector7d::Zero()), some_constants()}) {
    const Means means = over_runs(50, constants, 3);
    EXPECT_GT(means.pose, 0.85 * 9);
    EXPECT_LT(means.squares, chi2_band(7, 50, 0.999).high);
  }
}

TEST(TruthErrors, HaveTheirPriorWhereNothingDeterminesThem) {
  Simulated still = simulate(5, Vector7d::Zero());
  const auto rest = [](double) { return SE3{}; };
  still.estimate = test::sampled(kRate, kBegin, kEnd, rest);
  still.truth = test::sampled(200, 0, kEnd + 1, rest);
  const TruthErrors errors = found(still);
  EXPECT_TRUE(test::agree(errors.value, Vector7d::Zero(), 1e-9));
  EXPECT_NEAR(errors.sigma(0), TruthErrorPriors{}.time, 1e-9);
  // Of two headings, and of two tilts, a standstill determines the sum at most.
  EXPECT_NEAR(errors.sigma(3), TruthErrorPriors{}.rotation, 1e-6);
  EXPECT_NEAR(errors.sigma(6), TruthErrorPriors{}.rotation, 1e-6);
  EXPECT_FALSE(errors.significant(TruthErrorKind::kPositionTime));
  EXPECT_FALSE(errors.significant(TruthErrorKind::kBodyRotation));
  EXPECT_FALSE(errors.significant(TruthErrorKind::kWorldRotation));
}

TEST(TruthErrors, DoNotDependOnHeadingAndPositionOfTheWorlds) {
  const Simulated here = simulate(6, some_constants());
  Simulated elsewhere = here;
  const SE3 moved{so3::exp({0, 0, 2.1}), {30, -20, 5}};
  for (StampedPose& row : elsewhere.truth) row.pose = moved * row.pose;
  const TruthErrors a = found(here), b = found(elsewhere);
  Vector7d expected = a.value;
  expected.tail<3>() = moved.R * a.value.tail<3>();
  EXPECT_TRUE(test::agree(b.value, expected, 1e-6));
  // A sigma is widened along the axes of the truth's world.
  EXPECT_NEAR(b.nees.pose_summary.mean, a.nees.pose_summary.mean, 0.2);
  EXPECT_NEAR(b.first_heading, a.first_heading, 1e-6);
}

TEST(TruthErrors, NeedCovariancesOfFiveSeconds) {
  Simulated simulated = simulate(7, Vector7d::Zero());
  const auto message = [&]() -> std::string {
    try {
      found(simulated);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  simulated.covariances.assign(simulated.estimate.size(), Matrix6d::Zero());
  EXPECT_NE(message().find("found 0 poses with a truth and a covariance"), std::string::npos)
      << message();
  simulated.covariances.pop_back();
  EXPECT_NE(message().find("600 covariances for 601 poses"), std::string::npos) << message();
}

TEST(TruthErrors, ACovarianceThatIsNotOneIsLeftOut) {
  Simulated simulated = simulate(8, some_constants());
  const TruthErrors whole = found(simulated);
  simulated.covariances[300] = Matrix6d::Constant(kNaN);
  simulated.covariances[305](4, 4) = -1;
  const TruthErrors without = found(simulated);
  EXPECT_TRUE(test::agree(without.value, whole.value, 0.01));
  EXPECT_EQ(without.nees.pose_summary.skipped, whole.nees.pose_summary.skipped + 2);
}

}  // namespace
}  // namespace chasles
