#include <gtest/gtest.h>

#include <chasles/imu/signal_noise.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

constexpr double kPeriod = 0.1;

// A random walk of this density [unit/sqrt(s)] plus white noise.
std::vector<double> signal(std::size_t count, double walk, double white, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<double> samples;
  double value = 3;
  for (std::size_t i = 0; i < count; ++i) {
    samples.push_back(value + white * random.normal());
    value += walk * std::sqrt(kPeriod) * random.normal();
  }
  return samples;
}

TEST(MeasureSignal, SeparatesWhiteNoiseFromTheWalkUnderIt) {
  const SignalNoise noise = measure_signal(signal(5000, 0.3, 0.5, 1), kPeriod);
  // Three standard errors of a median of 5000 correlated differences: 5 % of s1 and of s2.
  EXPECT_NEAR(noise.white, 0.5, 0.08);
  EXPECT_NEAR(noise.walk, 0.3, 0.06);
}

TEST(MeasureSignal, APureWalkHasHardlyAnyWhiteNoise) {
  const SignalNoise noise = measure_signal(signal(5000, 1, 0, 2), kPeriod);
  EXPECT_LT(noise.white, 0.1);
  EXPECT_NEAR(noise.walk, 1, 0.1);
}

TEST(MeasureSignal, AConstantHasNoNoise) {
  const SignalNoise noise = measure_signal(std::vector<double>(100, 2.5), kPeriod);
  EXPECT_EQ(noise.white, 0);
  EXPECT_EQ(noise.walk, 0);
}

TEST(MeasureSignal, GrossErrorsHardlyChangeTheWhiteNoise) {
  std::vector<double> samples = signal(5000, 0.1, 0.5, 3);
  for (std::size_t i = 0; i < samples.size(); i += 100) samples[i] += 50;
  EXPECT_NEAR(measure_signal(samples, kPeriod).white, 0.5, 0.06);
}

TEST(MeasureSignal, ThreeSamplesShowNothing) {
  EXPECT_EQ(measure_signal(std::vector<double>{1, 2, 4}, kPeriod).white, 0);
  EXPECT_EQ(measure_signal({}, kPeriod).walk, 0);
}

TEST(RobustSigma, IsThatOfANormalDistributionWhateverTheOutliers) {
  std::vector<double> values = signal(5000, 0, 2, 4);
  for (double& value : values) value -= 3;
  for (std::size_t i = 0; i < values.size(); i += 20) values[i] = 1e6;
  EXPECT_NEAR(robust_sigma(values), 2, 0.2);
  EXPECT_EQ(robust_sigma({}), 0);
}

}  // namespace
}  // namespace chasles
