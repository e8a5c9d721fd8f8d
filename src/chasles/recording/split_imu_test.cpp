#include <algorithm>
#include <cmath>
#include <random>

#include <fmt/format.h>

#include <chasles/recording/split_imu.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::expect_parts;
using test::input_error;

const Eigen::Vector3d kForce(0.5, 0, 9.7);

SensorStream stream(const std::string& name, int count, Time period,
                    Time first = seconds(1'600'000'000), const Eigen::Vector3d& value = kForce) {
  SensorStream result{.name = name, .samples = {}};
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector3d noise(1e-3 * (k % 7), 1e-3 * (k % 5), 1e-3 * (k % 3));
    result.samples.push_back({.time = first + k * period, .value = value + noise});
  }
  return result;
}
SensorStream accel(int count = 100, Time period = milliseconds(16)) {
  return stream("/accel", count, period);
}
SensorStream gyro(int count = 300, Time period = milliseconds(5)) {
  return stream("/gyro", count, period);
}

Recording recording() {
  Recording r;
  r.imu_noise = ImuNoise{.accelerometer_noise_density = 0.01, .gyroscope_noise_density = 0.001};
  return r;
}

Recording joined(const SensorStream& forces, const SensorStream& rates) {
  Recording r = recording();
  join_streams("walk", forces, rates, Eigen::Matrix3d::Identity(), r);
  return r;
}

std::string rejection(const SensorStream& forces, const SensorStream& rates) {
  return input_error([&] { joined(forces, rates); });
}

TEST(SplitImu, ARemarkSaysWhatWasJoinedAndTheNoiseStays) {
  const Recording r = joined(accel(), gyro());
  EXPECT_EQ(r.imu.size(), 300u);
  EXPECT_EQ(r.imu_noise->accelerometer_noise_density, 0.01);
  ASSERT_EQ(r.remarks.size(), 1u);
  expect_parts(r.remarks[0], {"accelerometer (/accel, 62.5 Hz)", "gyroscope (/gyro, 200 Hz)",
                              "300 samples", "noise densities are those of the calibration"});
}

TEST(SplitImu, WhereTheGyroscopeIsSlowerTheNoiseGrows) {
  const Recording r = joined(accel(600, milliseconds(4)), gyro(100, milliseconds(12)));
  EXPECT_NEAR(r.imu_noise->accelerometer_noise_density, 0.01 * std::sqrt(2), 1e-12);
  EXPECT_EQ(r.imu_noise->gyroscope_noise_density, 0.001);
  expect_parts(r.remarks.at(0), {"the slower one", "1.41 times"});
}

// As for one table: a FIFO gives all samples of a batch the time of its last one.
TEST(SplitImu, BatchesOfEitherSensorAreSpread) {
  const auto batched = [](SensorStream s, std::size_t size) {
    for (std::size_t i = 0; i < s.samples.size(); ++i) {
      s.samples[i].time =
          s.samples[std::min(s.samples.size() - 1, i / size * size + size - 1)].time;
    }
    return s;
  };
  const Recording truth = joined(accel(300, milliseconds(5)), gyro());
  for (const std::size_t size : {std::size_t{2}, std::size_t{4}, std::size_t{10}}) {
    for (const bool of_forces : {true, false}) {
      const SensorStream forces = accel(300, milliseconds(5)), rates = gyro();
      const Recording r =
          of_forces ? joined(batched(forces, size), rates) : joined(forces, batched(rates, size));
      ASSERT_EQ(r.imu.size(), truth.imu.size()) << size;
      for (std::size_t k = 0; k < r.imu.size(); ++k) {
        EXPECT_EQ(r.imu[k].time, truth.imu[k].time);
        EXPECT_EQ(r.imu[k].specific_force_imu, truth.imu[k].specific_force_imu);
        EXPECT_EQ(r.imu[k].angular_rate_imu, truth.imu[k].angular_rate_imu);
      }
      expect_parts(r.remarks.at(0),
                   {"300 of 300 samples of the", of_forces ? "accelerometer" : "gyroscope",
                    fmt::format("in batches of {},", size)});
    }
  }
}

TEST(SplitImu, StreamsArePutInOrderAndWhatHasNoPartnerIsCounted) {
  SensorStream forces = accel(), rates = gyro(400);
  std::swap(forces.samples[20], forces.samples[21]);
  rates.samples.push_back(rates.samples.back());
  rates.samples[5].value.x() = NAN;
  forces.samples.erase(forces.samples.begin() + 50, forces.samples.begin() + 56);
  const Recording r = joined(forces, rates);
  std::string all;
  for (const std::string& remark : r.remarks) all += remark + "\n";
  expect_parts(all, {"1 of 94 samples of the accelerometer came after later ones",
                     "1 of 401 samples of the gyroscope repeat the time",
                     "1 of 400 samples of the gyroscope are not finite", "83 after its last",
                     "23 in gaps): left out"});
  for (std::size_t k = 1; k < r.imu.size(); ++k) EXPECT_GT(r.imu[k].time, r.imu[k - 1].time);
}

TEST(SplitImu, ARangeThatTheAccelerometerShowsMarksTheSamples) {
  SensorStream forces = accel();
  for (std::size_t k = 40; k < 44; ++k) forces.samples[k].value.z() = 39.2;
  const Recording r = joined(forces, gyro());
  EXPECT_NEAR(r.imu_range.accelerometer, 39.2, 0.05);
  std::size_t clipped = 0;
  for (const ImuSample& s : r.imu) clipped += s.force_clipped ? 1 : 0;
  EXPECT_EQ(clipped, 16u);  // between 39 and 44 periods of 16 ms
}

TEST(SplitImu, WhatCannotBeJoinedIsRejectedWithTheReason) {
  expect_parts(rejection(accel(5, seconds(1)), gyro(900)),
               {"walk: /accel", "accelerometer has 5 samples, at 1 Hz", "expected 20 Hz or more"});
  expect_parts(rejection(accel(300), gyro(5, seconds(1))), {"/gyro", "gyroscope has 5 samples"});
  expect_parts(rejection(stream("/accel", 100, milliseconds(16), seconds(5)), gyro()),
               {"accelerometer samples of /accel from 5.000 s (no date",
                "gyroscope samples of "
                "/gyro from 1600000000.000 s",
                "counts since boot"});
  expect_parts(rejection(stream("/accel", 100, milliseconds(16), seconds(1'600'003'600)), gyro()),
               {"1.00 h"});
  expect_parts(rejection(accel(0), gyro()), {"/accel: holds no sample", "accelerometer"});
  SensorStream unknown = gyro();
  for (AxesSample& s : unknown.samples) s.value.x() = NAN;
  expect_parts(rejection(accel(), unknown), {"/gyro", "none of the 300", "finite"});
  SensorStream same = accel();
  for (AxesSample& s : same.samples) s.time = seconds(1);
  expect_parts(rejection(same, gyro()), {"only 1 different time"});
  Recording means = recording();
  means.imu_convention = ImuConvention::kIntervalMean;
  expect_parts(input_error([&] {
                 join_streams("walk", accel(), gyro(), Eigen::Matrix3d::Identity(), means);
               }),
               {"interval-mean", "expected instant"});
}

// At 21 Hz with jitter two of five intervals are longer than 50 ms, over which nothing is joined.
TEST(SplitImu, ASensorWithTooManyLongIntervalsIsTooSlow) {
  const auto jittered = [](Time period, Time jitter) {
    SensorStream forces = accel(200, period);
    std::mt19937 random(5);
    for (AxesSample& s : forces.samples) {
      s.time += jitter * (static_cast<int>(random() % 2001) - 1000) / 1000;
    }
    return forces;
  };
  const SensorStream rates = gyro(2000);
  expect_parts(rejection(jittered(std::chrono::microseconds(47600), milliseconds(6)), rates),
               {"walk: /accel", "% of the intervals", "longer than 0.05 s",
                "the accelerometer is too slow", "20 Hz or more"});
  EXPECT_GT(joined(jittered(milliseconds(40), milliseconds(3)), rates).imu.size(), 1500u);
  SensorStream gaps = accel(600, milliseconds(16));
  const Time first = gaps.samples.front().time;
  std::erase_if(gaps.samples, [&](const AxesSample& s) {
    return (s.time - first) / milliseconds(1000) % 3 == 1;
  });
  EXPECT_GT(joined(gaps, rates).imu.size(), 1000u) << "a few long gaps";
}

// A FIFO delivers four samples with one time.
TEST(SplitImu, BatchesOfASensorAreSpread) {
  SensorStream rates = gyro(400);
  const SensorStream truth = rates;
  for (std::size_t i = 0; i < 400; ++i) rates.samples[i].time = truth.samples[i / 4 * 4 + 3].time;
  const Recording r = joined(accel(200), rates);
  ASSERT_EQ(r.imu.size(), 400u);
  for (std::size_t i = 0; i < 400; ++i) {
    EXPECT_LE(std::abs((r.imu[i].time - truth.samples[i].time).count()), 1000);
    EXPECT_EQ(r.imu[i].angular_rate_imu, truth.samples[i].value);
  }
  expect_parts(r.remarks.at(0), {"samples of the gyroscope have the time of others", "of 4"});
}

}  // namespace
}  // namespace chasles
