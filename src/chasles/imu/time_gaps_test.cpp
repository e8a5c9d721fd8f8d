#include <gtest/gtest.h>

#include <chasles/imu/sample_gaps.hpp>
#include <chasles/imu/time_gaps.hpp>

namespace chasles {
namespace {

using std::chrono::milliseconds;

TEST(TimeGaps, OnlyATimeWithoutMeasurementsThatIsTooLongIsAGap) {
  TimeGaps gaps;
  EXPECT_FALSE(gaps.last());
  EXPECT_FALSE(gaps.add(milliseconds(10000))) << "nothing is known before the first";
  EXPECT_FALSE(gaps.add(milliseconds(10000) + TimeGaps::kLongest)) << "it can be bridged";
  const auto gap = gaps.add(milliseconds(10001) + 2 * TimeGaps::kLongest);
  ASSERT_TRUE(gap);
  EXPECT_EQ(gap->last, milliseconds(10000) + TimeGaps::kLongest);
  EXPECT_EQ(gap->next, milliseconds(10001) + 2 * TimeGaps::kLongest);
  EXPECT_EQ(gaps.last(), gap->next);
}

TEST(TimeGaps, ATimeThatIsNotLaterChangesNothing) {
  TimeGaps gaps(milliseconds(700));
  EXPECT_FALSE(gaps.add(milliseconds(100)));
  EXPECT_FALSE(gaps.add(milliseconds(700)));
  EXPECT_EQ(gaps.last(), milliseconds(700));
  EXPECT_TRUE(gaps.add(milliseconds(1300)));
}

// Behind a screen, the gaps between raw samples are those between the ones that are released.
TEST(TimeGaps, BehindAScreenAreThoseOfSampleGaps) {
  const ImuRange range{.accelerometer = 156, .gyroscope = 34};
  SampleGaps raw(range);
  SampleScreen screen(range);
  TimeGaps screened;
  int gaps = 0;
  for (int k = 0; k < 400; ++k) {
    const bool zero = k >= 100 && k < 250;  // a driver that writes zeros for 0.75 s
    ImuSample sample{.time = milliseconds(5 * k)};
    if (!zero) {
      sample.specific_force_imu = Eigen::Vector3d(0.01 * (k % 7), 0, 9.81);
      sample.angular_rate_imu = Eigen::Vector3d(0.001 * (k % 5), 0, 0);
    }
    const auto a = raw.add(sample);
    std::optional<TimeGaps::Gap> b;
    for (const ImuSample& measured : screen.add(sample)) {
      if (const auto gap = screened.add(measured.time)) b = gap;
    }
    ASSERT_EQ(a.has_value(), b.has_value()) << k;
    EXPECT_EQ(raw.last(), screened.last());
    if (!a) continue;
    ++gaps;
    EXPECT_EQ(a->last, milliseconds(5 * 99));
    EXPECT_EQ(a->next, milliseconds(5 * 250));
    EXPECT_EQ(b->next, a->next);
  }
  EXPECT_EQ(gaps, 1);
}

}  // namespace
}  // namespace chasles
