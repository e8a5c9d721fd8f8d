#include <cmath>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <chasles/imu/join_imu.hpp>

namespace chasles {
namespace {

using std::chrono::milliseconds;

const Eigen::Vector3d kStill(0.3, -0.2, 9.8), kSlope(1, -2, 3);

std::vector<AxesSample> forces(int count, Time period = milliseconds(16),
                               Time first = milliseconds(1)) {
  std::vector<AxesSample> samples;
  for (int k = 0; k < count; ++k) {
    const Time time = first + k * period;
    samples.push_back({.time = time, .value = kStill + to_seconds(time) * kSlope});
  }
  return samples;
}

std::vector<AxesSample> rates(int count, Time period = milliseconds(5)) {
  std::vector<AxesSample> samples;
  for (int k = 0; k < count; ++k) {
    samples.push_back({.time = k * period, .value = Eigen::Vector3d(0.1 * k, -0.2, 1)});
  }
  return samples;
}

void append(const std::vector<ImuSample>& some, std::vector<ImuSample>& all) {
  all.insert(all.end(), some.begin(), some.end());
}

// `ahead`: by how much the stamps of the accelerometer lead in the order of arrival.
std::vector<ImuSample> joined(ImuJoiner& joiner, const std::vector<AxesSample>& f,
                              const std::vector<AxesSample>& w, Time ahead = {}) {
  std::vector<ImuSample> all;
  std::size_t i = 0;
  for (const AxesSample& rate : w) {
    while (i < f.size() && f[i].time < rate.time + ahead) append(joiner.add_force(f[i++]), all);
    append(joiner.add_rate(rate), all);
  }
  while (i < f.size()) append(joiner.add_force(f[i++]), all);
  return all;
}

TEST(ImuJoiner, GivesTheRatesAtTheirTimesAndALineOfForces) {
  ImuJoiner joiner;
  const auto w = rates(100);
  const std::vector<ImuSample> all = joined(joiner, forces(20), w);
  // From 1 ms to 305 ms: all but the first gyroscope sample, and those after the last force.
  ASSERT_EQ(all.size(), 61u);
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_EQ(all[k].time, w[k + 1].time);
    EXPECT_EQ(all[k].angular_rate_imu, w[k + 1].value);
    const Eigen::Vector3d line = kStill + to_seconds(all[k].time) * kSlope;
    EXPECT_LT((all[k].specific_force_imu - line).norm(), 1e-12);
    EXPECT_FALSE(all[k].force_clipped);
  }
  const ImuJoiner::Counts counts = joiner.counts();
  EXPECT_EQ(counts.joined, 61u);
  EXPECT_EQ(counts.before_forces, 1u);
  EXPECT_EQ(joiner.waiting(), 38u);
}

TEST(ImuJoiner, TheOrderOfArrivalMakesNoDifference) {
  std::vector<AxesSample> f = forces(300);
  f.erase(f.begin() + 100, f.begin() + 110);
  std::mt19937_64 random(1);
  for (AxesSample& one : f) one.value.x() += 1e-3 * static_cast<double>(random() % 1000);
  ImuJoiner first;
  const std::vector<ImuSample> expected = joined(first, f, rates(900));
  for (const int ahead : {-10'000, -300, 40, 10'000}) {
    ImuJoiner joiner;
    const std::vector<ImuSample> all = joined(joiner, f, rates(900), milliseconds(ahead));
    ASSERT_EQ(all.size(), expected.size());
    for (std::size_t k = 0; k < all.size(); ++k) {
      EXPECT_EQ(all[k].time, expected[k].time);
      EXPECT_EQ(all[k].specific_force_imu, expected[k].specific_force_imu);
    }
    EXPECT_EQ(joiner.counts().in_gaps, first.counts().in_gaps);
  }
}

TEST(ImuJoiner, AGapOfTheAccelerometerStaysOne) {
  std::vector<AxesSample> f = forces(40);
  f.erase(f.begin() + 11, f.begin() + 14);  // 64 ms between the samples at 161 and 225 ms
  ImuJoiner joiner;
  for (const ImuSample& s : joined(joiner, f, rates(120))) {
    EXPECT_TRUE(s.time <= milliseconds(161) || s.time >= milliseconds(225)) << s.time.count();
  }
  EXPECT_EQ(joiner.counts().in_gaps, 12u);  // 165 to 220 ms
  ImuJoiner at_limit;
  EXPECT_EQ(joined(at_limit, forces(9, milliseconds(50)), rates(80)).size(), 79u);
  ImuJoiner too_slow;
  EXPECT_EQ(joined(too_slow, forces(9, milliseconds(51)), rates(80)).size(), 1u) << "at 205 ms";
}

TEST(ImuJoiner, SamplesThatDependOnASaturatedOneAreMarkedAlongTheSensorsAxes) {
  std::vector<AxesSample> f = forces(40);
  f[20].value = Eigen::Vector3d(0, 0, 30);  // at 321 ms
  Eigen::Matrix3d turn;
  turn << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  ImuJoiner joiner({.accelerometer = 30, .gyroscope = 10}, turn);
  for (const ImuSample& s : joined(joiner, f, rates(120))) {
    EXPECT_EQ(s.force_clipped, s.time > milliseconds(305) && s.time < milliseconds(337))
        << s.time.count();
    if (s.force_clipped) continue;
    EXPECT_LT((s.specific_force_imu - turn * (kStill + to_seconds(s.time) * kSlope)).norm(), 1e-12);
  }
  EXPECT_EQ(turned_range(30, turn), 30);
  EXPECT_NEAR(turned_range(30, Eigen::AngleAxisd(M_PI / 4, Eigen::Vector3d::UnitX()).matrix()),
              30 * std::sqrt(2), 1e-12);
}

TEST(ImuJoiner, WhatIsNoMeasurementIsCounted) {
  std::vector<AxesSample> f = forces(60), w = rates(100);
  f[30].value.setZero();                     // what a driver writes without a measurement
  f[45].value = Eigen::Vector3d(0, 0, 900);  // a spike
  f[50].value.x() = NAN;
  w[7].value.y() = NAN;
  w[9].time = w[8].time;
  ImuJoiner joiner;
  for (const ImuSample& s : joined(joiner, f, w)) {
    EXPECT_LT((s.specific_force_imu - kStill - to_seconds(s.time) * kSlope).norm(), 1e-12);
  }
  const ImuJoiner::Counts counts = joiner.counts();
  EXPECT_EQ(counts.not_measured, 3u);
  EXPECT_EQ(counts.unknown_rates, 1u);
  EXPECT_EQ(counts.late_rates, 1u);
  EXPECT_EQ(counts.rates, counts.joined + counts.before_forces + 2);
}

TEST(ImuJoiner, ItsMemoryIsBounded) {
  ImuJoiner joiner;
  const int more = static_cast<int>(ImuJoiner::kMostWaiting) + 10;
  for (const AxesSample& rate : rates(more)) joiner.add_rate(rate);
  EXPECT_EQ(joiner.waiting(), ImuJoiner::kMostWaiting);
  EXPECT_EQ(joiner.counts().dropped_rates, 10u);
  ImuJoiner other;
  for (const AxesSample& force : forces(more)) other.add_force(force);
  EXPECT_EQ(other.counts().dropped_forces, 10u);
}

TEST(ImuJoiner, AfterAJumpOfTheClockItBeginsAnew) {
  ImuJoiner joiner;
  joined(joiner, forces(20), rates(100));
  joiner.restart_rates();
  joiner.restart_forces();
  EXPECT_EQ(joiner.waiting(), 0u);
  EXPECT_EQ(joined(joiner, forces(20), rates(100)).size(), 61u);
}

/// The variance of the integral of the joined force over a second, against that of the
/// accelerometer's white noise: N^2 per second. `period`: of the gyroscope, over the
/// accelerometer's.
double variance_ratio(double period) {
  constexpr double kAccel = 0.01, kSeconds = 3000;  // [s]
  std::mt19937_64 random(7);
  const auto uniform = [&] {
    return std::sqrt(12.0) * (static_cast<double>(random() >> 11) * 0x1p-53 - 0.5);
  };
  ImuJoiner joiner;
  std::vector<ImuSample> all;
  int next = 0;
  for (int k = 0; kAccel * k < kSeconds; ++k) {
    const AxesSample force{from_seconds(kAccel * k), {uniform(), uniform(), uniform()}};
    append(joiner.add_force(force), all);
    for (; period * kAccel * next < kAccel * k; ++next) {
      append(joiner.add_rate({from_seconds(period * kAccel * next), {1, 0, 0}}), all);
    }
  }
  double sum = 0;
  int seconds = 0;
  Eigen::Vector3d integral = Eigen::Vector3d::Zero();
  for (const ImuSample& s : all) {
    if (s.time > std::chrono::seconds(seconds + 1)) {
      sum += integral.squaredNorm() / 3;
      integral.setZero();
      ++seconds;
    }
    integral += period * kAccel * s.specific_force_imu;
  }
  return sum / seconds / kAccel;  // samples of variance 1: N^2 = kAccel
}

// docs/noise.md: the density of the accelerometer stays, unless the gyroscope is slower.
TEST(InterpolatedNoise, IsWhatTheIntegralOfJoinedSamplesShows) {
  EXPECT_NEAR(interpolated_noise(1), 1, 1e-12);
  EXPECT_NEAR(interpolated_noise(0.25), 1, 1e-3);
  EXPECT_NEAR(interpolated_noise(3), 2, 1e-12);
  // 9000 squares: four sigma are 6 %.
  for (const double period : {0.3137, 0.6451, 1.0, 1.5173, 2.0311, 3.1077}) {
    const double expected = interpolated_noise(period);
    EXPECT_NEAR(variance_ratio(period) / expected, 1, 0.06) << period;
  }
}

}  // namespace
}  // namespace chasles
