#include <vector>

#include <gtest/gtest.h>

#include <chasles/imu/sample_screen.hpp>
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

// A driver that writes zeros for 0.75 s leaves a gap of that time.
TEST(TimeGaps, BehindAScreenIsWhereASensorGivesNoMeasurement) {
  SampleScreen screen(ImuRange{.accelerometer = 156, .gyroscope = 34});
  std::vector<Time> times;
  for (int k = 0; k < 400; ++k) {
    const bool zero = k >= 100 && k < 250;
    ImuSample sample{.time = milliseconds(5 * k)};
    if (!zero) {
      sample.specific_force_imu = Eigen::Vector3d(0.01 * (k % 7), 0, 9.81);
      sample.angular_rate_imu = Eigen::Vector3d(0.001 * (k % 5), 0, 0);
    }
    for (const ImuSample& measured : screen.add(sample)) times.push_back(measured.time);
  }
  TimeGaps gaps;
  std::vector<TimeGaps::Gap> found;
  for (const Time time : times) {
    if (const auto gap = gaps.add(time)) found.push_back(*gap);
  }
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found.front().last, milliseconds(5 * 99));
  EXPECT_EQ(found.front().next, milliseconds(5 * 250));
}

}  // namespace
}  // namespace chasles
