#include <cmath>

#include <chasles/imu/imu_buffer.hpp>
#include <chasles/lie/testing.hpp>

// ImuBuffer with samples at the edge of a sensor's range.
namespace chasles {
namespace {

using std::chrono::milliseconds;

// f = (0, f, 1), w = (0, 0, w).
ImuSample of_two(int ms, double f, double w) {
  return {.time = milliseconds(ms), .specific_force_imu = {0, f, 1}, .angular_rate_imu = {0, 0, w}};
}
const ImuBuffer::Options kSmallRanges{.accelerometer_range = 16, .gyroscope_range = 4};

TEST(ImuSaturation, SaturatedSamplesAreCounted) {
  ImuBuffer buffer(kSmallRanges);
  buffer.add(of_two(10, 15.9, 3.9));
  EXPECT_EQ(buffer.counts().saturated, 0);
  buffer.add(of_two(20, -16, 0));
  EXPECT_EQ(buffer.counts().saturated, 1);
  buffer.add(of_two(30, 0, 4));
  buffer.add(of_two(40, 17, -5));  // both sensors: one sample
  EXPECT_EQ(buffer.counts().saturated, 3);
  EXPECT_EQ(buffer.counts().used, 4);
}

TEST(ImuSaturation, ASaturatedSensorIsBridgedAndTheOtherIsNot) {
  for (const auto& [convention, name] : Choices<ImuConvention>::list) {
    SCOPED_TRACE(name);
    ImuBuffer buffer({.convention = convention, .accelerometer_range = 16, .gyroscope_range = 4});
    buffer.add(of_two(10, 2, 1));
    buffer.add(of_two(20, 16, 2));
    buffer.add(of_two(30, 16, 3));
    buffer.add(of_two(40, 8, 3.5));
    const auto intervals = buffer.between(milliseconds(10), milliseconds(40));
    ASSERT_EQ(intervals.size(), 3u);
    const bool instant = is_force_of_instant(convention);
    const bool instant_rate = is_rate_of_instant(convention);
    // Over the first two intervals the line from 2 to 8; 16 is (11, 9) above it in their middles.
    const std::vector<double> force{3, 5, instant ? 7. : 8.}, sigma{8 + 13, 8 + 11, 8 + 9};
    const std::vector<double> rate{instant_rate ? 1.5 : 2, instant_rate ? 2.5 : 3,
                                   instant_rate ? 3.25 : 3.5};
    for (std::size_t i = 0; i < 3; ++i) {
      SCOPED_TRACE(i);
      EXPECT_NEAR(intervals[i].specific_force_imu.y(), force[i], 1e-12);
      const bool bridged = i < 2 || instant;
      EXPECT_NEAR(intervals[i].accelerometer_extra_density,
                  bridged ? sigma[i] * std::sqrt(0.03) : 0, 1e-12);
      EXPECT_NEAR(intervals[i].angular_rate_imu.z(), rate[i], 1e-12);
      EXPECT_EQ(intervals[i].gyroscope_extra_density, 0);
      EXPECT_EQ(intervals[i].noise_scale, 1);
    }
  }
}

TEST(ImuSaturation, ASaturatedSensorHoldsItsLastValueUntilItIsBack) {
  ImuBuffer buffer(kSmallRanges);
  buffer.add(of_two(10, 2, 1));
  buffer.add(of_two(20, 2, 4));
  buffer.add(of_two(30, 2, 4));
  const ImuInterval held = buffer.between(milliseconds(20), milliseconds(30)).at(0);
  EXPECT_EQ(held.angular_rate_imu.z(), 1);
  EXPECT_NEAR(held.gyroscope_extra_density, (2 + 3) * std::sqrt(0.02), 1e-12);
  // Removing samples keeps the start of the bridge.
  buffer.drop_before(milliseconds(30));
  buffer.add(of_two(40, 2, 2));
  const ImuInterval back = buffer.between(milliseconds(30), milliseconds(40)).at(0);
  EXPECT_NEAR(back.angular_rate_imu.z(), 1 + 25. / 30, 1e-12);
  ImuBuffer never(kSmallRanges);
  never.add(of_two(10, 2, 5));
  never.add(of_two(20, 2, 5));
  const ImuInterval used = never.between(milliseconds(10), milliseconds(20)).at(0);
  EXPECT_EQ(used.angular_rate_imu.z(), 5);
  EXPECT_NEAR(used.gyroscope_extra_density, 4 * std::sqrt(0.01), 1e-12);
}

TEST(ImuSaturation, ASensorThatStaysSaturatedDoesNotFillTheMemory) {
  ImuBuffer buffer(kSmallRanges);
  buffer.add(of_two(0, 0, 0));
  for (int ms = 5; ms < 20'000; ms += 5) buffer.add(of_two(ms, 16, 0));
  buffer.drop_before(milliseconds(19'990));
  // Nothing of the first second remains: a call there holds the first sample.
  buffer.between(milliseconds(18'000), milliseconds(18'001));
  EXPECT_EQ(buffer.counts().extrapolated, 1);
}

// NEES of a velocity over a time with saturation. The signal either exceeds the range smoothly, or
// reports the range without any true shock.
double saturation_nees(double peak, bool false_blow) {
  test::Random random(5);
  double sum = 0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    const double width = random.uniform(0.02, 0.1), size = random.uniform(0.6, 1) * peak;
    ImuBuffer buffer(kSmallRanges);
    double truth = 0;
    for (int ms = -200; ms <= 200; ++ms) {
      const double f = false_blow ? 0 : size * std::exp(-std::pow(1e-3 * ms / width, 2));
      truth += 1e-3 * f * (std::abs(ms) == 200 ? 0.5 : 1);
      if (ms % 5 != 0) continue;
      const bool blow = false_blow && std::abs(ms) < 1e3 * width / 2;
      buffer.add(of_two(ms, blow ? 16 : std::min(f, 16.), 0));
    }
    InertialState x;
    double variance = 0;
    for (const ImuInterval& i : buffer.between(milliseconds(-200), milliseconds(200))) {
      const StrapdownStep step =
          strapdown(x, i, Eigen::Vector3d::Zero(), {.accelerometer_noise_density = 2e-3});
      x = step.state;
      variance += step.Q(7, 7);
    }
    sum += std::pow(x.v_world.y() - truth, 2) / variance;
  }
  return sum / kTrials;
}

// At most one, so that the filter is not overconfident, and not so small that the samples are
// wasted.
TEST(ImuSaturation, WhatSaturationHidesIsWithinTheNoiseThatIsClaimed) {
  for (const double peak : {24., 32.}) {
    const double nees = saturation_nees(peak, false);
    EXPECT_LT(nees, 1) << peak;
    EXPECT_GT(nees, 0.02) << peak;
  }
  EXPECT_LT(saturation_nees(0, true), 0.1);
  EXPECT_LT(saturation_nees(15, false), 0.5) << "nothing is saturated";
}

}  // namespace
}  // namespace chasles
