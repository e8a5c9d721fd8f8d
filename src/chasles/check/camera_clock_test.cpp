#include <gtest/gtest.h>

#include <chasles/check/camera_clock.hpp>
#include <chasles/check/check_testing.hpp>

// The offset of images that are stamped late, against what the test shifted them by.
namespace chasles {
namespace {

using test::tracked;

std::optional<CameraClock> clock_of(const Recording& r) {
  return camera_clock(r.frames, r.cameras, r.imu);
}

Recording late(double seconds, const test::TrackedSettings& settings = {}) {
  Recording r = tracked(settings);
  for (FeatureFrame& frame : r.frames) frame.time += from_seconds(seconds);
  return r;
}

TEST(CameraClock, AnOffsetIsMeasuredToAMillisecond) {
  for (const double seconds : {0.1, 0.095, 0.048, 0.02, -0.02, -0.1, -0.3}) {
    const auto clock = clock_of(late(seconds, {.outliers = 0.1}));
    ASSERT_TRUE(clock);
    EXPECT_NEAR(clock->offset, -seconds, 3 * clock->sigma) << seconds;
    EXPECT_LE(clock->sigma, 0.0015);
    EXPECT_TRUE(clock->stands_out()) << seconds;
  }
}

TEST(CameraClock, WhatAFilterFindsByItselfDoesNotStandOut) {
  for (const double seconds : {0.0, 0.005, -0.008}) {
    const auto clock = clock_of(late(seconds));
    ASSERT_TRUE(clock);
    EXPECT_FALSE(clock->stands_out()) << seconds;
  }
}

TEST(CameraClock, AnUncertainOffsetDoesNotStandOut) {
  EXPECT_TRUE((CameraClock{.offset = -0.011, .sigma = 0.001}).stands_out());
  EXPECT_FALSE((CameraClock{.offset = -0.009, .sigma = 0.0005}).stands_out());
  EXPECT_TRUE((CameraClock{.offset = 0.025, .sigma = 0.002}).stands_out());
  EXPECT_FALSE((CameraClock{.offset = 0.025, .sigma = 0.003}).stands_out());
}

TEST(CameraClock, OfAMirroredGyroscopeIsMeasuredWithItsSigns) {
  Recording flipped = late(0.095);
  for (ImuSample& s : flipped.imu) s.angular_rate_imu.y() *= -1;
  ASSERT_TRUE(clock_of(flipped));
  EXPECT_NEAR(clock_of(flipped)->offset, -0.095, 0.002);
}

TEST(CameraClock, AMotionThatIsNotTheGyroscopesShowsNothing) {
  Recording other = late(0.095), still = late(0.095);
  for (ImuSample& s : other.imu) s.angular_rate_imu *= 57.3;
  for (ImuSample& s : still.imu) s.angular_rate_imu.setZero();
  EXPECT_FALSE(clock_of(other));
  EXPECT_FALSE(clock_of(still));
  EXPECT_FALSE(camera_clock({}, still.cameras, still.imu));
  EXPECT_FALSE(camera_clock(still.frames, {}, still.imu));
}

}  // namespace
}  // namespace chasles
