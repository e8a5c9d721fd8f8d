#include <gtest/gtest.h>

#include <chasles/check/check_testing.hpp>
#include <chasles/check/clock_drift.hpp>

// Images by a clock that runs slow or fast, against what the test stretched their times by.
namespace chasles {
namespace {

using test::tracked;

Recording stretched(double rate) {
  Recording r = tracked({.outliers = 0.1});
  for (FeatureFrame& frame : r.frames) {
    frame.time -= from_seconds(rate * to_seconds(frame.time - r.frames.front().time));
  }
  return r;
}

TEST(ClockDrift, OfAnotherFrameRateIsMeasuredAndNamed) {
  for (const double rate : {2e-3, -2e-3}) {
    const Recording r = stretched(rate);
    const auto drift = clock_drift(r.frames, r.cameras, r.imu);
    ASSERT_TRUE(drift);
    EXPECT_NEAR(drift->rate, rate, 3 * drift->sigma) << rate;
    EXPECT_TRUE(drift->stands_out()) << rate << " +- " << drift->sigma;
    CheckReport report;
    report_clock_drift(drift, report);
    ASSERT_EQ(report.findings.size(), 1u);
    EXPECT_NE(report.findings[0].what.find(rate > 0 ? "its clock loses" : "its clock gains"),
              std::string::npos);
  }
}

TEST(ClockDrift, OfOneClockDoesNotStandOut) {
  const Recording r = stretched(0);
  const auto drift = clock_drift(r.frames, r.cameras, r.imu);
  ASSERT_TRUE(drift);
  EXPECT_NEAR(drift->rate, 0, 3 * drift->sigma);
  CheckReport report;
  report_clock_drift(drift, report);
  report_clock_drift({}, report);
  EXPECT_TRUE(report.findings.empty());
}

TEST(ClockDrift, NeedsTracksThatTurnAsTheGyroscope) {
  Recording still = stretched(0);
  for (ImuSample& s : still.imu) s.angular_rate_imu.setZero();
  EXPECT_FALSE(clock_drift(still.frames, still.cameras, still.imu));
  EXPECT_FALSE(clock_drift({}, still.cameras, still.imu));
}

}  // namespace
}  // namespace chasles
