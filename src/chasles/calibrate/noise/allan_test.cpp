#include <cmath>
#include <numbers>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <chasles/calibrate/noise/allan.hpp>
#include <chasles/calibrate/noise/noise_testing.hpp>

namespace chasles::test {
namespace {

double variance_of(const std::vector<double>& samples, std::size_t m) {
  const AllanSum sum = allan_sum(running_sums(samples), m);
  return sum.squares / (2 * static_cast<double>(sum.differences));
}

TEST(Allan, ARampHasItsClosedForm) {
  constexpr double kSlope = 0.3, kPeriod = 0.02;
  std::vector<double> samples;
  for (int i = 0; i < 200; ++i) samples.push_back(5 + kSlope * kPeriod * i);
  for (const std::size_t m : {1, 7, 40, 100}) {
    const double tau = static_cast<double>(m) * kPeriod;
    EXPECT_NEAR(variance_of(samples, m), kSlope * kSlope * tau * tau / 2, 1e-12) << m;
  }
}

TEST(Allan, SamplesThatAlternateCancelInEvenMeans) {
  std::vector<double> samples;
  for (int i = 0; i < 50; ++i) samples.push_back(i % 2 == 0 ? 1 : -1);
  EXPECT_DOUBLE_EQ(variance_of(samples, 1), 2);
  EXPECT_DOUBLE_EQ(variance_of(samples, 2), 0);
  EXPECT_NEAR(variance_of(samples, 3), 2.0 / 9, 1e-15);
}

TEST(Allan, TheSumIsThatOfTheDefinition) {
  const std::vector<double> samples = simulated_standstill(1, 1, 1, 100, 4);
  for (const std::size_t m : {1, 3, 50}) {
    double squares = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i + 2 * m <= samples.size(); ++i, ++count) {
      double difference = 0;
      for (std::size_t k = 0; k < m; ++k) {
        difference += (samples[i + m + k] - samples[i + k]) / static_cast<double>(m);
      }
      squares += difference * difference;
    }
    const AllanSum sum = allan_sum(running_sums(samples), m);
    EXPECT_NEAR(sum.squares, squares, 1e-12 * squares);
    EXPECT_EQ(sum.differences, count);
  }
  EXPECT_EQ(allan_sum(running_sums(samples), 51).differences, 0u);
  EXPECT_EQ(allan_sum(running_sums(samples), 0).differences, 0u);
}

TEST(Allan, FactorsAreWholeAndRise) {
  const std::vector<std::size_t> factors = allan_factors(100);
  EXPECT_EQ(factors.front(), 1u);
  EXPECT_EQ(factors.back(), 100u);
  for (std::size_t i = 1; i < factors.size(); ++i) EXPECT_GT(factors[i], factors[i - 1]);
  EXPECT_TRUE(allan_factors(0).empty());
}

// Mean and variance of the estimate by matrices: it is the quadratic form x^T A x of Gaussian x,
// with mean tr(A P) and variance 2 tr(A P A P).
struct ByMatrices {
  double mean = 0, dof = 0;
};

ByMatrices by_matrices(const NoisePower& power, Eigen::Index m, double period, Eigen::Index n) {
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < n; ++k) {
      covariance(i, k) = power.walk * period * static_cast<double>(std::min(i, k)) +
                         (i == k ? power.white / period : 0);
    }
  }
  const Eigen::Index differences = n - 2 * m + 1;
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(differences, n);
  for (Eigen::Index i = 0; i < differences; ++i) {
    D.row(i).segment(i, m).setConstant(-1.0 / static_cast<double>(m));
    D.row(i).segment(i + m, m).setConstant(1.0 / static_cast<double>(m));
  }
  const Eigen::MatrixXd P = D * covariance * D.transpose() / (2 * static_cast<double>(differences));
  const double mean = P.trace();
  return {.mean = mean, .dof = 2 * mean * mean / (2 * (P * P).trace())};
}

TEST(Allan, VarianceAndDegreesOfFreedomOfWhiteNoiseAndAWalkAreExact) {
  constexpr double kPeriod = 0.1;
  constexpr Eigen::Index kSamples = 60;
  for (const NoisePower& power :
       {NoisePower{.white = 0.4}, NoisePower{.walk = 2}, NoisePower{.white = 0.4, .walk = 2}}) {
    for (const Eigen::Index m : {1, 2, 5, 20, 30}) {
      const ByMatrices wanted = by_matrices(power, m, kPeriod, kSamples);
      const auto size = static_cast<std::size_t>(m);
      EXPECT_NEAR(allan_variance(power, size, kPeriod), wanted.mean, 1e-12 * wanted.mean) << m;
      EXPECT_NEAR(allan_degrees_of_freedom(power, size, kPeriod, kSamples), wanted.dof,
                  1e-10 * wanted.dof)
          << m;
    }
  }
  EXPECT_EQ(allan_degrees_of_freedom({.white = 1}, 31, kPeriod, kSamples), 0);
}

// Where differences are many, they are not all summed.
TEST(Allan, DegreesOfFreedomOfLongMeansScaleWithTheSamples) {
  const NoisePower white{.white = 1};
  const double few = allan_degrees_of_freedom(white, 60, 1, 6000);
  const double many = allan_degrees_of_freedom(white, 6000, 1, 600000);
  EXPECT_NEAR(many / few, 1, 2e-3);
}

TEST(Allan, AFlickerHasTheFlatDeviationAndItsScatter) {
  constexpr double kB = 0.5;
  constexpr std::size_t kSamples = 2000, kMean = 100;
  constexpr int kRuns = 40;
  const NoisePower power{.instability = kB * kB};
  double sum = 0, squares = 0;
  for (int run = 0; run < kRuns; ++run) {
    const double variance =
        variance_of(simulated_flicker(kB, kSamples, static_cast<std::uint64_t>(run)), kMean);
    sum += variance;
    squares += variance * variance;
  }
  const double mean = sum / kRuns, scatter = squares / kRuns - mean * mean;
  const double expected = 2 * std::numbers::ln2 / std::numbers::pi * kB * kB;
  EXPECT_DOUBLE_EQ(allan_variance(power, kMean, 1), expected);
  const double dof = allan_degrees_of_freedom(power, kMean, 1, kSamples);
  EXPECT_NEAR(mean, expected, 3 * expected * std::sqrt(2 / (dof * kRuns)));
  // The variance of 40 runs' variance is known to 22 %.
  EXPECT_NEAR(2 * expected * expected / scatter / dof, 1, 0.7);
}

}  // namespace
}  // namespace chasles::test
