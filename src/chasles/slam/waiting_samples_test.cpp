#include <initializer_list>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/slam/waiting_samples.hpp>

namespace chasles {
namespace {

WaitingSamples at(std::initializer_list<int> times) {
  WaitingSamples samples;
  for (const int time : times) samples.add({.time = Time(time)});
  return samples;
}

std::vector<int> times(const WaitingSamples& samples) {
  std::vector<int> list;
  for (const ImuSample& sample : samples.all())
    list.push_back(static_cast<int>(sample.time.count()));
  return list;
}

TEST(WaitingSamples, KeepTheLastOneBeforeTheTime) {
  WaitingSamples samples = at({10, 20, 30, 40, 50});
  samples.drop_before(Time(35));
  EXPECT_EQ(times(samples), (std::vector{30, 40, 50}));
  samples.drop_before(Time(40));
  EXPECT_EQ(times(samples), (std::vector{30, 40, 50})) << "40 begins no interval before 40";
  samples.drop_before(Time(5));
  EXPECT_EQ(times(samples), (std::vector{30, 40, 50}));
}

TEST(WaitingSamples, KeepTheNewestTwo) {
  WaitingSamples samples = at({10, 20, 30});
  samples.drop_before(Time(1000));
  EXPECT_EQ(times(samples), (std::vector{20, 30}));
  EXPECT_EQ(samples.newest().time, Time(30));
  WaitingSamples none;
  none.drop_before(Time(1000));
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace chasles
