#include <cmath>
#include <numbers>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <chasles/calibrate/noise/cosine_powers.hpp>
#include <chasles/calibrate/noise/noise_testing.hpp>

namespace chasles::test {
namespace {

// By the definition of the orthonormal DCT-II.
Eigen::MatrixXd cosines(Eigen::Index n) {
  Eigen::MatrixXd C(n, n);
  const auto size = static_cast<double>(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const double angle =
          std::numbers::pi * static_cast<double>(j) * (static_cast<double>(i) + 0.5) / size;
      C(j, i) = std::sqrt((j == 0 ? 1 : 2) / size) * std::cos(angle);
    }
  }
  return C;
}

TEST(CosinePowers, TheTransformIsThatOfTheDefinition) {
  for (const std::size_t n : {1, 2, 15, 16, 54}) {
    const std::vector<double> samples = simulated_standstill(1, 0.5, 1, n, 9);
    const auto size = static_cast<Eigen::Index>(n);
    Eigen::VectorXd wanted =
        cosines(size) * Eigen::Map<const Eigen::VectorXd>(samples.data(), size);
    wanted[0] = 0;  // that of the mean
    const std::vector<double> found = cosine_transform(samples);
    EXPECT_LT((Eigen::Map<const Eigen::VectorXd>(found.data(), size) - wanted).norm(), 1e-12) << n;
  }
}

// The covariance of white noise on a random walk becomes diagonal, with the stated variances.
TEST(CosinePowers, TheCoefficientsOfAWalkAreIndependent) {
  constexpr Eigen::Index kSamples = 30;
  constexpr double kPeriod = 0.1, kN = 0.3, kK = 0.7;
  Eigen::MatrixXd covariance(kSamples, kSamples);
  for (Eigen::Index i = 0; i < kSamples; ++i) {
    for (Eigen::Index k = 0; k < kSamples; ++k) {
      covariance(i, k) = kK * kK * kPeriod * static_cast<double>(std::min(i, k)) +
                         (i == k ? kN * kN / kPeriod : 0);
    }
  }
  const Eigen::MatrixXd C = cosines(kSamples).bottomRows(kSamples - 1);
  Eigen::MatrixXd found = C * covariance * C.transpose();
  const auto bands =
      cosine_powers(simulated_standstill(kN, kK, kPeriod, kSamples, 1), kPeriod, 1e9);
  ASSERT_EQ(bands.size(), 29u);  // one for each coefficient
  for (Eigen::Index j = 0; j < kSamples - 1; ++j) {
    const NoisePower& parts = bands[static_cast<std::size_t>(j)].parts;
    const double variance = (kN * kN * parts.white + kK * kK * parts.walk) / kPeriod;
    EXPECT_NEAR(found(j, j), variance, 1e-10 * variance);
    found(j, j) = 0;
  }
  EXPECT_LT(found.cwiseAbs().maxCoeff(), 1e-10);
}

TEST(CosinePowers, BandsHoldAllCoefficientsUpToTheFrequency) {
  const double period = 0.01;
  const std::vector<double> samples = simulated_standstill(1, 0, period, 3001, 2);
  const std::size_t n = smooth_length(samples.size());
  EXPECT_EQ(n, 3000u);
  const auto bands = cosine_powers(samples, period, 10);
  const std::vector<double> coefficients = cosine_transform(std::span(samples).first(n));
  double count = 0, squares = 0, wanted = 0;
  for (const PowerBand& band : bands) {
    count += band.count;
    squares += band.count * band.power;
  }
  for (std::size_t j = 1; j <= 600; ++j) wanted += coefficients[j] * coefficients[j] * period;
  EXPECT_EQ(count, 600);  // 2 * 30 s * 10 Hz
  EXPECT_NEAR(squares, wanted, 1e-12 * wanted);
  EXPECT_LT(bands.size(), 300u);
  EXPECT_LE(bands.back().frequency, 10);
  EXPECT_TRUE(cosine_powers(std::span(samples).first(15), period, 10).empty());
}

}  // namespace
}  // namespace chasles::test
