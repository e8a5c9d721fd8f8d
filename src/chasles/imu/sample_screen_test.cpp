#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/imu/imu_buffer.hpp>
#include <chasles/imu/sample_screen.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

using std::chrono::milliseconds;

// A hand-held sensor at 200 Hz, with or without noise.
std::vector<ImuSample> swing(int count, double noise = 1) {
  test::Random random(7);
  std::vector<ImuSample> samples;
  for (int k = 0; k < count; ++k) {
    const double t = 0.005 * k;
    const Eigen::Vector3d force(std::sin(t), 0, 9.81 + std::cos(3 * t));
    const Eigen::Vector3d rate(0.5 * std::sin(2 * t), 0.3, 0);
    samples.push_back({.time = milliseconds(5 * (k + 1)),
                       .specific_force_imu = force + 0.1 * noise * random.normal_vector(3),
                       .angular_rate_imu = rate + 0.01 * noise * random.normal_vector(3)});
  }
  return samples;
}

std::vector<ImuSample> screened(const std::vector<ImuSample>& samples,
                                SampleScreen::Counts& counts) {
  SampleScreen screen{ImuRange{.accelerometer = 156, .gyroscope = 34}};
  std::vector<ImuSample> released;
  for (const ImuSample& sample : samples) {
    for (const ImuSample& good : screen.add(sample)) released.push_back(good);
  }
  counts = screen.counts();
  return released;
}

void expect_left_out(const std::vector<ImuSample>& samples, const std::vector<std::size_t>& out) {
  SampleScreen::Counts counts;
  const std::vector<ImuSample> released = screened(samples, counts);
  std::vector<Time> expected, actual;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (std::find(out.begin(), out.end(), k) == out.end()) expected.push_back(samples[k].time);
  }
  for (const ImuSample& sample : released) actual.push_back(sample.time);
  EXPECT_EQ(actual, expected);
}

TEST(SampleScreen, ReleasesASignalAsItIs) {
  for (const double noise : {0.0, 1.0, 10.0}) expect_left_out(swing(1000, noise), {});
}

TEST(SampleScreen, LeavesOutASpikeOfEitherSensor) {
  auto samples = swing(400);
  samples[200].angular_rate_imu.x() = 30;
  samples[300].specific_force_imu.y() = -150;
  SampleScreen::Counts counts;
  screened(samples, counts);
  EXPECT_EQ(counts.spikes, 2);
  expect_left_out(samples, {200, 300});
}

TEST(SampleScreen, KeepsABlowThatLastsForTwoSamples) {
  auto samples = swing(400);
  for (const std::size_t k : {200u, 201u}) samples[k].specific_force_imu.z() = 100;
  expect_left_out(samples, {});
}

TEST(SampleScreen, KeepsAStepAndTheSaturatedSamplesOfABlow) {
  auto samples = swing(400);
  for (std::size_t k = 200; k < 400; ++k) samples[k].angular_rate_imu.z() += 6;
  expect_left_out(samples, {});
  samples = swing(400);
  samples[200].specific_force_imu.z() = 156;  // bridged by the buffer, with its noise
  expect_left_out(samples, {});
}

TEST(SampleScreen, LeavesOutZerosAndWhatIsNotFinite) {
  auto samples = swing(100);
  for (std::size_t k = 5; k < 100; k += 10) {
    samples[k].specific_force_imu.setZero();
    samples[k].angular_rate_imu.setZero();
  }
  samples[50].angular_rate_imu.y() = std::nan("");
  expect_left_out(samples, {5, 15, 25, 35, 45, 50, 55, 65, 75, 85, 95});
}

TEST(SampleScreen, ReleasesNoneOfAFrozenSensor) {
  auto samples = swing(1000);
  for (std::size_t k = 401; k < 800; ++k) {
    samples[k].specific_force_imu = samples[400].specific_force_imu;
    samples[k].angular_rate_imu = samples[400].angular_rate_imu;
  }
  std::vector<std::size_t> out;
  for (std::size_t k = 401; k < 800; ++k) out.push_back(k);
  expect_left_out(samples, out);
}

// As if a gap had been filled, with the digits of a file.
void fill(std::vector<ImuSample>& samples, std::size_t first, std::size_t last,
          double digit = 1e-9) {
  const auto rounded = [digit](const Eigen::Vector3d& v) -> Eigen::Vector3d {
    return digit * (v / digit).array().round();
  };
  for (std::size_t k = first + 1; k < last; ++k) {
    const double x = static_cast<double>(k - first) / static_cast<double>(last - first);
    samples[k].specific_force_imu =
        rounded((1 - x) * samples[first].specific_force_imu + x * samples[last].specific_force_imu);
    samples[k].angular_rate_imu =
        rounded((1 - x) * samples[first].angular_rate_imu + x * samples[last].angular_rate_imu);
  }
}

std::vector<std::size_t> between(std::size_t first, std::size_t last) {
  std::vector<std::size_t> all;
  for (std::size_t k = first + 1; k < last; ++k) all.push_back(k);
  return all;
}

// The first of the filled samples show nothing yet.
TEST(SampleScreen, LeavesOutTheSamplesOfAFilledGap) {
  for (const double digit : {1e-12, 1e-6}) {
    auto samples = swing(1000);
    fill(samples, 400, 500, digit);
    expect_left_out(samples, between(403, 500));
    SampleScreen::Counts counts;
    screened(samples, counts);
    EXPECT_EQ(counts.interpolated, 96);
  }
}

TEST(SampleScreen, LeavesOutAGapThatWasFilledAtTheBeginning) {
  auto samples = swing(1000);
  fill(samples, 0, 140);
  expect_left_out(samples, between(3, 140));
}

TEST(SampleScreen, FindsLinesBetweenSparseSamples) {
  auto samples = swing(1000);
  std::vector<std::size_t> out;
  for (std::size_t k = 400; k < 700; k += 50) {
    fill(samples, k, k + 50);
    for (const std::size_t i : between(k + 3, k + 50)) out.push_back(i);
  }
  expect_left_out(samples, out);
}

TEST(SampleScreen, AShortLineIsReleasedLater) {
  auto samples = swing(1000);
  fill(samples, 400, 418);
  expect_left_out(samples, {});
}

// A sensor without noise may turn or be accelerated evenly.
TEST(SampleScreen, KeepsTheLinesOfASensorWithoutNoise) {
  auto samples = swing(1000, 0);
  fill(samples, 400, 600);
  expect_left_out(samples, {});
}

// Numbers as at a standstill show nothing: a walker's are so at every eighth sample.
TEST(SampleScreen, FreezesAtNumbersAsAtStandstillToo) {
  auto samples = swing(1000);
  std::vector<std::size_t> out;
  for (std::size_t k = 400; k < 800; ++k) {
    samples[k].specific_force_imu = {0, 0, 9.81};
    samples[k].angular_rate_imu.setZero();
    if (k > 400) out.push_back(k);
  }
  expect_left_out(samples, out);
}

TEST(SampleScreen, RepeatsForLessThanATenthOfASecondAreReleasedLater) {
  auto samples = swing(1000);
  for (std::size_t k = 401; k <= 420; ++k) {
    samples[k].specific_force_imu = samples[400].specific_force_imu;
    samples[k].angular_rate_imu = samples[400].angular_rate_imu;
  }
  expect_left_out(samples, {});
}

// As an ideal sensor of a simulation, at a standstill and in a steady turn; as one that is read
// twice.
TEST(SampleScreen, KeepsRepeatsThatAreNoFault) {
  auto samples = swing(1000, 0);
  for (std::size_t k = 401; k < 800; ++k) {
    samples[k].specific_force_imu = {0, 0, 9.81};
    samples[k].angular_rate_imu.setZero();
  }
  expect_left_out(samples, {});
  samples = swing(1000);
  for (std::size_t k = 0; k < 1000; ++k) {
    samples[k].specific_force_imu = {0.5, 0, 9.81};
    samples[k].angular_rate_imu = {0, 0, k < 500 ? 0.2 : 0.3};
  }
  expect_left_out(samples, {});
  samples = swing(1000);
  for (std::size_t k = 1; k < 1000; ++k) {
    if (k % 40 == 0) continue;
    samples[k].specific_force_imu = samples[k - 1].specific_force_imu;
    samples[k].angular_rate_imu = samples[k - 1].angular_rate_imu;
  }
  expect_left_out(samples, {});
}

TEST(SampleScreen, TheBufferBridgesASpikeByTheLineThroughItsNeighbours) {
  auto samples = swing(400, 0);
  const double x = samples[200].angular_rate_imu.x();
  samples[200].angular_rate_imu.x() = 30;
  ImuBuffer buffer({});
  for (const ImuSample& sample : samples) EXPECT_TRUE(buffer.add(sample));
  EXPECT_EQ(buffer.counts().spikes, 1);
  EXPECT_EQ(buffer.counts().used, 399);
  const auto bridged = buffer.between(samples[199].time, samples[201].time);
  ASSERT_EQ(bridged.size(), 1U);
  EXPECT_NEAR(bridged[0].angular_rate_imu.x(), x, 1e-4);
}

}  // namespace
}  // namespace chasles
