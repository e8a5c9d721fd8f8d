#include <chrono>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/pipeline/arrival_order.hpp>

namespace chasles {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

ImuSample sample_at(int ms, double rate = 0) {
  ImuSample sample;
  sample.time = std::chrono::milliseconds(ms);
  sample.angular_rate_imu.setConstant(rate);
  return sample;
}

ImageFrame frame_at(int ms) { return {.time = std::chrono::milliseconds(ms), .images = {}}; }

std::string name_of(const SensorEvent& event) {
  const auto* sample = std::get_if<ImuSample>(&event);
  const Time time = sample ? sample->time : std::get<ImageFrame>(event).time;
  return (sample ? "s" : "F") +
         std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(time).count());
}

/// The events whose place is known, such as "s0 s5 F5".
std::string due(ArrivalOrder& order) {
  std::string names;
  while (const auto event = order.next()) names += (names.empty() ? "" : " ") + name_of(*event);
  return names;
}

std::string rest(ArrivalOrder& order) {
  std::string names;
  while (const auto event = order.next_at_end()) {
    names += (names.empty() ? "" : " ") + name_of(*event);
  }
  return names;
}

TEST(ArrivalOrder, AFrameFollowsTheFirstSampleThatIsNotEarlier) {
  ArrivalOrder order;
  for (const int ms : {0, 10, 20, 30}) order.add(sample_at(ms));
  EXPECT_EQ(due(order), "");
  order.add(frame_at(10));
  EXPECT_EQ(due(order), "s0 s10 F10");
  order.add(frame_at(35));
  EXPECT_EQ(due(order), "");
  order.add(frame_at(15));
  EXPECT_EQ(due(order), "s20 F15");
  order.add(sample_at(40));
  EXPECT_EQ(due(order), "s30 s40 F35");
  order.add(sample_at(50));
  order.add(frame_at(60));
  EXPECT_EQ(due(order), "");
  EXPECT_EQ(order.waiting_frames(), 1u);
  EXPECT_EQ(rest(order), "s50 F60");
  EXPECT_EQ(order.counts().images_uncovered, 1u);
}

// As EventStream: the first sample of all comes first, even if it is later.
TEST(ArrivalOrder, TheFirstSampleComesBeforeTheFirstFrame) {
  ArrivalOrder order;
  order.add(frame_at(10));
  order.add(frame_at(12));
  order.add(sample_at(20));
  order.add(sample_at(30));
  EXPECT_EQ(due(order), "s20 F10 F12");
  EXPECT_EQ(rest(order), "s30");
}

TEST(ArrivalOrder, WhatIsLateOrRepeatedIsLeftOutAndCounted) {
  ArrivalOrder order;
  order.add(sample_at(10));
  order.add(frame_at(10));
  EXPECT_EQ(due(order), "s10 F10");
  order.add(sample_at(10));
  order.add(sample_at(5));
  order.add(frame_at(10));
  EXPECT_EQ(due(order), "");
  EXPECT_EQ(order.counts().samples_late, 2u);
  EXPECT_EQ(order.counts().images_late, 1u);
  // Of two that wait with the same time the first one counts.
  order.add(sample_at(20, 1));
  order.add(sample_at(20, 2));
  order.add(frame_at(15));
  order.add(frame_at(15));
  EXPECT_EQ(std::get<ImuSample>(order.next().value()).angular_rate_imu.x(), 1);
  EXPECT_EQ(due(order), "F15");
  EXPECT_EQ(rest(order), "");
  EXPECT_EQ(order.counts().samples_late, 3u);
  EXPECT_EQ(order.counts().images_late, 2u);
  EXPECT_EQ(order.counts().samples, 5u);
  EXPECT_EQ(order.counts().images, 4u);
}

TEST(ArrivalOrder, ASampleThatIsNotFiniteCoversNoFrame) {
  ArrivalOrder order;
  order.add(sample_at(0));
  order.add(frame_at(5));
  order.add(sample_at(5, kNan));
  EXPECT_EQ(due(order), "");
  order.add(sample_at(10));
  EXPECT_EQ(due(order), "s0 s5 s10 F5");
  EXPECT_EQ(order.counts().samples_not_finite, 1u);
}

TEST(ArrivalOrder, OnlySoManyFramesWait) {
  ArrivalOrder order;
  const int most = static_cast<int>(ArrivalOrder::kMostFrames);
  for (int k = 0; k < most; ++k) order.add(frame_at(100 + k));
  order.add(sample_at(1));
  EXPECT_EQ(due(order), "");
  order.add(frame_at(100 + most));
  EXPECT_EQ(due(order), "s1 F100");
  EXPECT_EQ(order.counts().images_uncovered, 1u);
  order.add(sample_at(1000));  // the samples go on
  EXPECT_EQ(due(order).substr(0, 16), "s1000 F101 F102 ");
  EXPECT_EQ(order.waiting_frames(), 0u);
  EXPECT_EQ(order.counts().images_uncovered, 1u);
}

TEST(ArrivalOrder, OnlySoManySamplesWait) {
  ArrivalOrder order;
  const int most = static_cast<int>(ArrivalOrder::kMostSamples);
  for (int k = 0; k < most + 3; ++k) order.add(sample_at(k));
  EXPECT_EQ(order.counts().samples_dropped, 3u);
  order.add(frame_at(4));
  EXPECT_EQ(due(order), "s3 s4 F4");
}

}  // namespace
}  // namespace chasles
