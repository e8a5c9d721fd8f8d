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
    return SE3{so3::exp(-world) * test::walk_at(t).R * so3::exp(-body),
               test::walk_at(t - time).p};
  });
}

// An estimate as an inertial filter has it: heading and position walk randomly from the first pose
// on, an error of heading turns what follows about that pose, and the tilt is a stationary process.
// The covariances are exact. `overconfident`: the errors are that many times too large.
Simulated simulate(std::uint64_t seed, const Vector7d& constants, double overconfident = 1) {
  test::Random random(seed);
  Simulated result{.estimate = test::sampled(kRate, kBegin, kEnd), .truth = truth_with(constants), .covariances = {}};
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

// Means over runs, with bounds of 3 of their own standard errors.
struct Means {
  double pose = 0, position = 0, attitude = 0, before = 0, squares = 0;
  double pose_sigma = 0;
  int significant = 0;
};

Means over_runs(int runs, const Vector7d& constants, double overconfident = 1) {
  Means means;
  double of_squares = 0;
  for (int k = 0; k < runs; ++k) {
    const Simulated simulated =
        simulate(100 + static_cast<std::uint64_t>(k), constants, overconfident);
    const TruthErrors errors = found(simulated);
    const double pose = errors.nees.pose_summary.mean / 6 / runs;
    means.pose += pose;
    of_squares += pose * pose * runs;
    means.position += errors.nees.position_summary.mean / 3 / runs;
    means.attitude += errors.nees.attitude_summary.mean / 3 / runs;
    means.before += nees(associate(simulated.estimate, simulated.truth), simulated.covariances,
                         PoseError::kStandard, true)
                        .pose_summary.mean /
                    6 / runs;
    means.squares += square(errors, constants) / 7 / runs;
    for (const auto kind : {TruthErrorKind::kPositionTime, TruthErrorKind::kBodyRotation,
                            TruthErrorKind::kWorldRotation}) {
      means.significant += errors.significant(kind);
    }
  }
  means.pose_sigma = std::sqrt((of_squares - means.pose * means.pose) / runs);
  return means;
}

TEST(TruthErrors, PrintMeans) {
  for (const double factor : {1.0, 2.0, 3.0}) {
    for (const Vector7d& c : {Vector7d(Vector7d::Zero()), some_constants()}) {
      const Means m = over_runs(100, c, factor);
      printf("factor %.1f: before %.2f pose %.2f +- %.2f position %.2f attitude %.2f squares/7 %.2f significant %d\n", factor,
             m.before, m.pose, m.pose_sigma, m.position, m.attitude, m.squares, m.significant);
    }
  }
}

}  // namespace
}  // namespace chasles
