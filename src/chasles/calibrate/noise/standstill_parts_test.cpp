#include <gtest/gtest.h>

#include <chasles/calibrate/noise/noise_testing.hpp>
#include <chasles/calibrate/noise/standstill_parts.hpp>

namespace chasles::test {
namespace {

double begin_of(const EvenSpan& span) { return to_seconds(span.begin); }
double end_of(const EvenSpan& span) { return to_seconds(span.end); }

TEST(StandstillParts, AStandstillBetweenMotionsIsFoundWithoutItsEnds) {
  Recording recording = standstill_recording(40, 100, kSensorNoise, 2);
  add_motion(recording, 0, 10);
  add_motion(recording, 30, 40);
  const StandstillParts parts = find_standstill_parts(even_samples(recording.imu, {}).spans);
  ASSERT_EQ(parts.standstill.size(), 1u);
  EXPECT_GE(begin_of(parts.standstill[0]), 10.3);
  EXPECT_LE(begin_of(parts.standstill[0]), 11.1);
  EXPECT_LE(end_of(parts.standstill[0]), 29.7);
  EXPECT_GE(end_of(parts.standstill[0]), 28.9);
  EXPECT_EQ(parts.motion.size(), 2u);
  EXPECT_GT(parts.longest, 19);
}

TEST(StandstillParts, AStandstillFromEndToEndIsWhole) {
  const Recording recording = standstill_recording(20, 100, kSensorNoise, 3);
  const StandstillParts parts = find_standstill_parts(even_samples(recording.imu, {}).spans);
  ASSERT_EQ(parts.standstill.size(), 1u);
  EXPECT_EQ(parts.standstill[0].count(), recording.imu.size());
  EXPECT_TRUE(parts.motion.empty());
}

TEST(StandstillParts, AFastSensorMayScatterMore) {
  ImuNoise noise = kSensorNoise;
  noise.accelerometer_noise_density = 4e-3;  // sigma of a sample: 0.18 m/s^2
  const Recording recording = standstill_recording(5, 2000, noise, 6);
  const StandstillParts parts = find_standstill_parts(even_samples(recording.imu, {}).spans);
  ASSERT_EQ(parts.standstill.size(), 1u);
  EXPECT_EQ(parts.standstill[0].count(), recording.imu.size());
}

TEST(StandstillParts, ATouchIsLeftOut) {
  Recording recording = standstill_recording(20, 100, kSensorNoise, 4);
  for (std::size_t i = 1000; i < 1020; ++i) {  // 0.1 m/s^2: still a standstill
    recording.imu[i].specific_force_imu.x() += i % 2 == 0 ? 0.3 : -0.3;
  }
  const StandstillParts parts = find_standstill_parts(even_samples(recording.imu, {}).spans);
  ASSERT_EQ(parts.standstill.size(), 2u);
  EXPECT_LE(end_of(parts.standstill[0]), 10.0);
  EXPECT_GE(begin_of(parts.standstill[1]), 10.2);
}

TEST(StandstillParts, AMotionHasNoStandstill) {
  Recording recording = standstill_recording(20, 100, kSensorNoise, 5);
  add_motion(recording, 0, 20);
  const StandstillParts parts = find_standstill_parts(even_samples(recording.imu, {}).spans);
  EXPECT_TRUE(parts.standstill.empty());
  ASSERT_EQ(parts.motion.size(), 1u);
  EXPECT_EQ(parts.motion[0].count(), recording.imu.size());
}

}  // namespace
}  // namespace chasles::test
