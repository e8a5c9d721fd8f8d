#include <chasles/recording/recording.hpp>
#include <chasles/recording/testing.hpp>
#include <chasles/recording/time_order.hpp>

namespace chasles {
namespace {

using std::chrono::milliseconds;

// Samples at 100 Hz from one time to another [ms], with the number of each as its angular rate.
std::vector<ImuSample> samples(int from, int to) {
  std::vector<ImuSample> imu;
  for (int t = from; t < to; t += 10) {
    imu.push_back({.time = milliseconds(t), .angular_rate_imu = {t * 1.0, 0, 0}});
  }
  return imu;
}

std::vector<ImuSample> operator+(std::vector<ImuSample> a, const std::vector<ImuSample>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

std::vector<std::string> remarks_on(std::vector<ImuSample> imu) {
  std::vector<std::string> remarks;
  bring_into_order(imu, "IMU samples", remarks);
  EXPECT_TRUE(std::ranges::is_sorted(imu, {}, &ImuSample::time));
  return remarks;
}

std::string error(const std::vector<ImuSample>& imu) {
  return test::input_error([&] { remarks_on(imu); });
}

TEST(TimeOrder, AClockThatWasSetBackIsRejected) {
  const std::string text = error(samples(0, 8000) + samples(5003, 9000));
  test::expect_parts(text, {"IMU samples: the clock was set back by 2.987 s", "row 801 of 1200"});
  // On the same grid of times, with other measurements.
  std::vector<ImuSample> later = samples(5000, 9000);
  for (ImuSample& sample : later) sample.angular_rate_imu.y() = 1;
  EXPECT_NE(error(samples(0, 8000) + later).find("row 801"), std::string::npos);
}

TEST(TimeOrder, DisorderWithoutAMixIsMended) {
  EXPECT_EQ(remarks_on(samples(0, 900)).size(), 0u);
  EXPECT_EQ(remarks_on(samples(5000, 9000) + samples(0, 5000)).size(), 1u);  // stretches exchanged
  EXPECT_EQ(remarks_on(samples(0, 9000) + samples(3000, 6000)).size(), 2u);  // copies
  EXPECT_EQ(remarks_on(samples(0, 2000) + samples(1805, 3000)).size(), 1u);  // too short to decide
}

}  // namespace
}  // namespace chasles
