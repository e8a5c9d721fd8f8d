#include <gtest/gtest.h>

#include <chasles/calibrate/noise/even_samples.hpp>
#include <chasles/calibrate/noise/noise_testing.hpp>

namespace chasles::test {
namespace {

std::vector<ImuSample> noisy(double seconds) {
  return standstill_recording(seconds, 100, kSensorNoise, 1).imu;
}

EvenSamples even(const std::vector<ImuSample>& samples) { return even_samples(samples, {}); }

TEST(EvenSamples, SamplesWithoutAGapAreOneSpan) {
  const std::vector<ImuSample> samples = noisy(3);
  const EvenSamples result = even(samples);
  ASSERT_EQ(result.spans.size(), 1u);
  EXPECT_EQ(result.spans[0].count(), samples.size());
  EXPECT_NEAR(result.spans[0].period, 0.01, 1e-9);
  EXPECT_EQ(result.spans[0].signals[2][7], samples[7].specific_force_imu.z());
  EXPECT_EQ(result.spans[0].signals[3][7], samples[7].angular_rate_imu.x());
  EXPECT_EQ(result.lost + result.early, 0u);
}

TEST(EvenSamples, AFewLostSamplesAreInterpolatedAndMoreAreAGap) {
  std::vector<ImuSample> samples = noisy(3);
  samples.erase(samples.begin() + 200, samples.begin() + 205);  // 5
  samples.erase(samples.begin() + 100, samples.begin() + 104);  // 4
  const EvenSamples result = even(samples);
  ASSERT_EQ(result.spans.size(), 2u);
  EXPECT_EQ(result.lost, 4u);
  EXPECT_EQ(result.spans[0].count(), 200u);
  EXPECT_EQ(result.spans[1].count(), 95u);
  const std::vector<double>& x = result.spans[0].signals[0];
  EXPECT_NEAR(x[101], x[99] + 0.4 * (x[104] - x[99]), 1e-15);
}

TEST(EvenSamples, StampsThatJitterLoseNothing) {
  std::vector<ImuSample> samples = noisy(30);
  const Random random{.seed = 3};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].time += from_seconds(0.004 * (random.uniform(Stream::kStart, i) - 0.5));
  }
  const EvenSamples result = even(samples);
  ASSERT_EQ(result.spans.size(), 1u);
  EXPECT_EQ(result.spans[0].count(), samples.size());
  EXPECT_EQ(result.lost, 0u);
}

TEST(EvenSamples, ARoundedMedianIntervalLosesNothingInALongRecording) {
  std::vector<ImuSample> samples = noisy(100);
  for (std::size_t i = 0; i < samples.size(); ++i) {  // 100.3 Hz, stamps in whole milliseconds
    samples[i].time = std::chrono::milliseconds(std::lround(static_cast<double>(i) * 9.97));
  }
  const EvenSamples result = even(samples);
  ASSERT_EQ(result.spans.size(), 1u);
  EXPECT_EQ(result.lost, 0u);
  EXPECT_NEAR(result.spans[0].period, 0.00997, 1e-6);
}

TEST(EvenSamples, BurstsAreCounted) {
  std::vector<ImuSample> samples = noisy(3);
  for (std::size_t i = 0; i < samples.size();
       ++i) {  // four at a time, as a driver may deliver them
    samples[i].time =
        from_seconds(0.04 * static_cast<double>(i / 4) + 1e-4 * static_cast<double>(i % 4));
  }
  EXPECT_GT(even(samples).early + even(samples).lost, 100u);
}

TEST(EvenSamples, WhatIsNoMeasurementIsLeftOut) {
  std::vector<ImuSample> samples = noisy(3);
  samples[100].specific_force_imu.setZero();
  samples[100].angular_rate_imu.setZero();
  samples[150].angular_rate_imu.x() = std::numeric_limits<double>::quiet_NaN();
  const EvenSamples result = even(samples);
  EXPECT_EQ(result.screen.zero, 1);
  EXPECT_EQ(result.screen.not_finite, 1);
  EXPECT_EQ(result.lost, 2u);
  EXPECT_EQ(result.spans[0].count(), samples.size());
}

TEST(EvenSamples, OfNoSamplesThereIsNoSpan) {
  EXPECT_TRUE(even({}).spans.empty());
  EXPECT_TRUE(even({noisy(1).front()}).spans.empty());
}

}  // namespace
}  // namespace chasles::test
