#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/pipeline/fault_testing.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/testing.hpp>

// A real flight of which somebody has filled a gap of the IMU by interpolation.

namespace chasles {
namespace {

using namespace test;

std::filesystem::path flight_with_images() {
  const auto tracks = recordings();
  return tracks ? tracks->parent_path() / "euroc/MH_01_easy_17s" : std::filesystem::path();
}

void interpolate(FaultySensors& s, double from, double to) {
  std::vector<ImuSample*> filled;
  for (ImuSample& sample : s.imu) {
    if (s.within(sample.time, from, to)) filled.push_back(&sample);
  }
  const ImuSample first = *filled.front(), last = *filled.back();
  for (ImuSample* sample : filled) {
    const double x = to_seconds(sample->time - first.time) / to_seconds(last.time - first.time);
    sample->specific_force_imu = (1 - x) * first.specific_force_imu + x * last.specific_force_imu;
    sample->angular_rate_imu = (1 - x) * first.angular_rate_imu + x * last.angular_rate_imu;
  }
}

// From the fourth second on, with two cameras; nothing is filled if `to` is `from`.
FaultOutcome outcome_of_gap(const std::filesystem::path& folder, double from, double to) {
  const Recording recording = read_recording(folder);
  const DecodedImages images(recording.images);
  FaultySensors sensors(recording, images, 4, 6, 2);
  if (to > from) interpolate(sensors, from, to);
  return run(sensors, recording, 1);
}

TEST(FilledGap, IsBridgedAsAGap) {
  const std::filesystem::path folder = flight_with_images();
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "skipped: no recordings";
  const FaultOutcome o = outcome_of_gap(folder, 3, 3.4);
  EXPECT_TRUE(o.running) << why_not_initialised(o.latest, o.requirements);
  EXPECT_EQ(o.false_ok, 0);
  EXPECT_LE(o.ate, 0.04);
  EXPECT_EQ(o.resets, 0);
}

TEST(FilledGap, NoRunStartsInIt) {
  const std::filesystem::path folder = flight_with_images();
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "skipped: no recordings";
  for (const double end : {0.0, 1.5}) {
    const FaultOutcome o = outcome_of_gap(folder, 0, end);
    EXPECT_TRUE(o.running) << why_not_initialised(o.latest, o.requirements);
    EXPECT_GE(o.started, end);
    EXPECT_LE(o.started, end + 1.5);
    EXPECT_LE(o.ate, 0.04);
  }
}

}  // namespace
}  // namespace chasles
