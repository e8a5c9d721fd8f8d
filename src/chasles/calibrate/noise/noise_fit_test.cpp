#include <numbers>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/noise/noise_fit.hpp>
#include <chasles/calibrate/noise/noise_testing.hpp>
#include <chasles/eval/chi2.hpp>

namespace chasles::test {
namespace {

constexpr double kHighest = 10;  // [Hz]

NoiseFit fit_of_samples(const std::vector<double>& samples, double period) {
  return fit_noise(cosine_powers(samples, period, kHighest));
}

struct Standstill {
  double rate, seconds, N, K;
  NoiseFit fit(std::uint64_t run) const {
    const auto samples = static_cast<std::size_t>(seconds * rate);
    return fit_of_samples(simulated_standstill(N, K, 1 / rate, samples, run), 1 / rate);
  }
};

// Where K is shown, the errors of ln N and ln K are two normal variables of the stated covariance;
// where it is not, that of ln N is one, and K is below its limit.
TEST(NoiseFit, SigmasOfStandstillsOfAnyLengthAndRateAreTrue) {
  constexpr std::uint64_t kRuns = 240;
  std::size_t white = 0, walk = 0, shown = 0, below = 0;
  double nees_of_both = 0, nees_of_white = 0;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Standstill standstill{.rate = std::array{20., 50., 100., 200.}[run % 4],
                                .seconds = std::array{30., 100., 300., 1000.}[(run / 4) % 4],
                                .N = 2e-4,
                                .K = std::array{1e-5, 3e-5, 1e-4}[(run / 16) % 3]};
    const NoiseFit fit = standstill.fit(run);
    const double of_white = std::log(fit.white.value / standstill.N);
    white += std::abs(of_white) < 3 * fit.white.relative_sigma ? 1 : 0;
    if (fit.walk.shown) {
      const Eigen::Vector2d error(of_white, std::log(fit.walk.value / standstill.K));
      walk += std::abs(error[1]) < 3 * fit.walk.relative_sigma ? 1 : 0;
      nees_of_both += error.dot(fit.covariance.inverse() * error);
      ++shown;
    } else {
      nees_of_white += of_white * of_white / fit.covariance(0, 0);
      below += standstill.K < fit.walk.limit ? 1 : 0;
    }
  }
  const std::size_t limited = kRuns - shown;
  EXPECT_GE(static_cast<double>(white), 0.98 * kRuns);
  EXPECT_GE(static_cast<double>(walk), 0.98 * static_cast<double>(shown));
  EXPECT_GE(static_cast<double>(below), 0.9 * static_cast<double>(limited));  // 95 % in the mean
  ASSERT_GT(shown, 100u);
  ASSERT_GT(limited, 50u);
  EXPECT_TRUE(chi2_band(2, shown, 0.99).contains(nees_of_both / static_cast<double>(shown)))
      << nees_of_both / static_cast<double>(shown);
  EXPECT_TRUE(chi2_band(1, limited, 0.99).contains(nees_of_white / static_cast<double>(limited)))
      << nees_of_white / static_cast<double>(limited);
}

TEST(NoiseFit, AShortStandstillGivesALimitOfTheWalk) {
  const Standstill standstill{.rate = 100, .seconds = 30, .N = 2e-4, .K = 1e-5};
  const NoiseFit fit = standstill.fit(1);
  EXPECT_TRUE(fit.white.shown);
  EXPECT_FALSE(fit.walk.shown);
  EXPECT_FALSE(fit.instability.shown);
  EXPECT_GT(fit.walk.limit, standstill.K);
  EXPECT_LT(fit.walk.limit, 1e-4);  // of the order of N over the length
  EXPECT_EQ(fit.power.walk, 0);
}

TEST(NoiseFit, WithoutWhiteNoiseOnlyItsLimitIsKnown) {
  const Standstill standstill{.rate = 50, .seconds = 100, .N = 0, .K = 1e-3};
  const NoiseFit fit = standstill.fit(3);
  EXPECT_FALSE(fit.white.shown);
  EXPECT_GT(fit.white.limit, 0);
  EXPECT_NEAR(std::log(fit.walk.value / standstill.K), 0, 3 * fit.walk.relative_sigma);
}

TEST(NoiseFit, AnInstabilityIsDistinguishedFromAWalk) {
  constexpr double kN = 2e-4, kB = 6e-4, kRate = 20;
  constexpr std::size_t kSamples = 6000;
  for (std::uint64_t run = 0; run < 3; ++run) {
    std::vector<double> samples = simulated_standstill(kN, 0, 1 / kRate, kSamples, run);
    const std::vector<double> flicker = simulated_flicker(kB, kSamples, run);
    for (std::size_t i = 0; i < kSamples; ++i) samples[i] += flicker[i];
    const NoiseFit fit = fit_of_samples(samples, 1 / kRate);
    ASSERT_TRUE(fit.instability.shown);
    EXPECT_NEAR(std::log(fit.instability.value / kB), 0, 3 * fit.instability.relative_sigma);
    EXPECT_NEAR(std::log(fit.white.value / kN), 0, 3 * fit.white.relative_sigma);
    EXPECT_FALSE(fit.walk.shown);
    EXPECT_GT(fit.walk_without_instability, fit.walk.limit);  // it stands for the instability
  }
}

TEST(NoiseFit, WhatIsAboveAVibrationIsLeftOut) {
  constexpr double kN = 2e-4, kRate = 100;
  std::vector<double> samples = simulated_standstill(kN, 0, 1 / kRate, 6000, 5);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] += 1e-3 * std::sin(2 * std::numbers::pi * 7 * static_cast<double>(i) / kRate);
  }
  const NoiseFit fit = fit_of_samples(samples, 1 / kRate);
  EXPECT_LT(fit.white_up_to, 7);
  EXPECT_GT(fit.white_up_to, 3);
  EXPECT_NEAR(std::log(fit.white.value / kN), 0, 3 * fit.white.relative_sigma);
}

// A motion from 0.3 to 0.9 Hz: the model does not hold, and the sigmas say so.
TEST(NoiseFit, AMisfitEnlargesTheSigmas) {
  const Standstill standstill{.rate = 50, .seconds = 200, .N = 2e-4, .K = 0};
  std::vector<double> samples =
      simulated_standstill(standstill.N, 0, 1 / standstill.rate, 10000, 6);
  const double sigma = fit_of_samples(samples, 1 / standstill.rate).white.relative_sigma;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double time = static_cast<double>(i) / standstill.rate;
    for (int k = 30; k < 90; ++k) {
      samples[i] += 1e-4 * std::sin(2 * std::numbers::pi * 0.01 * k * time + k * k);
    }
  }
  const NoiseFit fit = fit_of_samples(samples, 1 / standstill.rate);
  EXPECT_GT(fit.misfit, 3);
  EXPECT_GT(fit.white.relative_sigma, 3 * sigma);
}

TEST(NoiseFit, NothingToFitIsAnError) {
  EXPECT_THROW(fit_noise({}), InputError);
  EXPECT_THROW(fit_of_samples(std::vector<double>(100, 1.5), 0.01), InputError);
}

}  // namespace
}  // namespace chasles::test
