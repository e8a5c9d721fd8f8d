#include <cmath>
#include <numbers>

#include <chasles/imu/imu_buffer.hpp>
#include <chasles/imu/vibration_noise.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;

constexpr double kForceDensity = 0.02, kRateDensity = 0.002;

/// Two seconds at a rate: white noise of the densities above, and a tone of the given amplitude on
/// all axes of the force. Returns the last added noise.
AddedNoise after_two_seconds(double rate, double amplitude, double frequency, double from = 0,
                             VibrationNoise noise = {}) {
  test::Random random(1);
  AddedNoise added;
  const double dt = 1 / rate;
  for (int i = 0; i < static_cast<int>(2 * rate); ++i) {
    const double t = from + i * dt;
    const double tone = amplitude * std::sin(2 * std::numbers::pi * frequency * t);
    added =
        noise.add({.time = from_seconds(t),
                   .specific_force_imu = Vector3d(0, 0, 9.8) + Vector3d::Constant(tone) +
                                         kForceDensity / std::sqrt(dt) * random.normal_vector(3),
                   .angular_rate_imu = kRateDensity / std::sqrt(dt) * random.normal_vector(3)});
  }
  return added;
}

// White noise of density N has <D^2> dt = N^2 at every rate.
TEST(VibrationNoise, OfWhiteNoiseIsAFixedPartOfItsDensity) {
  for (const double rate : {100.0, 200.0, 500.0, 1000.0}) {
    const AddedNoise added = after_two_seconds(rate, 0, 0);
    EXPECT_NEAR(added.accelerometer, 0.5 * kForceDensity, 0.1 * kForceDensity) << rate;
    EXPECT_NEAR(added.gyroscope, 0.15 * kRateDensity, 0.1 * kRateDensity) << rate;
  }
}

// A tone's <D^2> is half of (amplitude 2 cos(w/2) sin w)^2, w its phase per sample.
TEST(VibrationNoise, OfAToneIsThatOfItsDifferences) {
  constexpr double kRate = 200, kAmplitude = 3;
  for (const double frequency : {43.0, 190.0}) {  // 190 Hz appears as 10 Hz
    const double w = 2 * std::numbers::pi * frequency / kRate;
    const double gain = 2 * std::cos(w / 2) * std::sin(w);
    const double square = kAmplitude * kAmplitude * gain * gain / 2;
    const double slow = std::max(0.0, kAmplitude * kAmplitude / 2 - square);
    const double expected = std::sqrt(0.25 * square / kRate + 0.005 * 0.005 * slow +
                                      0.25 * kForceDensity * kForceDensity);
    const AddedNoise added = after_two_seconds(kRate, kAmplitude, frequency);
    EXPECT_NEAR(added.accelerometer, expected, 0.05 * expected) << frequency;
    EXPECT_LT(added.gyroscope, 0.25 * kRateDensity);
  }
}

TEST(VibrationNoise, DoesNotDependOnWhatIsLongPast) {
  VibrationNoise used;
  for (int i = 0; i < 400; ++i) {
    used.add({.time = from_seconds(0.005 * i),
              .specific_force_imu = Vector3d::Constant(i % 2 == 0 ? 1e6 : -1e6),
              .angular_rate_imu = Vector3d::Constant(i)});
  }
  const AddedNoise fresh = after_two_seconds(200, 1, 43, 10);
  const AddedNoise later = after_two_seconds(200, 1, 43, 10, used);
  EXPECT_EQ(fresh.accelerometer, later.accelerometer);
  EXPECT_EQ(fresh.gyroscope, later.gyroscope);
}

TEST(VibrationNoise, NeedsFourSamplesWithoutAGap) {
  VibrationNoise noise;
  const auto add = [&](int ms, bool saturated = false) {
    return noise.add({.time = std::chrono::milliseconds(ms),
                      .specific_force_imu = Vector3d::Constant(ms % 2),
                      .angular_rate_imu = Vector3d::Constant(ms % 3)},
                     {.force = saturated});
  };
  for (const int ms : {0, 5, 10}) EXPECT_EQ(add(ms).accelerometer, 0);
  for (const int ms : {100, 105, 110}) EXPECT_EQ(add(ms).gyroscope, 0);  // after a gap
  const AddedNoise unusable = add(115, true);
  EXPECT_EQ(unusable.accelerometer, 0);
  EXPECT_GT(unusable.gyroscope, 0);
}

TEST(VibrationNoise, IsInTheBuffersIntervalsWhereAskedFor) {
  constexpr double kFactor = 4;
  ImuBuffer plain({}), once({.vibration_noise = 1}), more({.vibration_noise = kFactor});
  VibrationNoise expected;
  AddedNoise last;
  test::Random random(2);
  for (int i = 0; i < 100; ++i) {
    const ImuSample sample{.time = std::chrono::milliseconds(5 * i),
                           .specific_force_imu = random.normal_vector(3),
                           .angular_rate_imu = random.normal_vector(3)};
    last = expected.add(sample);
    for (ImuBuffer* buffer : {&plain, &once, &more}) buffer->add(sample);
  }
  const Time from = std::chrono::milliseconds(490), to = std::chrono::milliseconds(495);
  EXPECT_EQ(plain.between(from, to).back().accelerometer_extra_density, 0);
  EXPECT_DOUBLE_EQ(once.between(from, to).back().accelerometer_extra_density, last.accelerometer);
  EXPECT_DOUBLE_EQ(once.between(from, to).back().gyroscope_extra_density, last.gyroscope);
  EXPECT_DOUBLE_EQ(more.between(from, to).back().gyroscope_extra_density,
                   std::sqrt(kFactor) * last.gyroscope);
  once.drop_before(std::chrono::milliseconds(480));
  EXPECT_DOUBLE_EQ(once.between(from, to).back().gyroscope_extra_density, last.gyroscope);
}

}  // namespace
}  // namespace chasles
