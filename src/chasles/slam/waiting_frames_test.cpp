#include <gtest/gtest.h>

#include <chasles/slam/waiting_frames.hpp>

namespace chasles {
namespace {

TEST(WaitingFrames, LeaveInOrderAndOnlyWhenCovered) {
  WaitingFrames<int> waiting;
  for (const int time : {1, 2, 5}) waiting.add(time);
  int now = 0;
  const auto covered = [&](int time) { return time <= now; };
  EXPECT_FALSE(waiting.next(covered));
  now = 3;
  EXPECT_EQ(waiting.next(covered), 1);
  EXPECT_EQ(waiting.next(covered), 2);
  EXPECT_FALSE(waiting.next(covered));  // 5 waits, and is still there
  EXPECT_EQ(waiting.size(), 1u);
  EXPECT_EQ(waiting.next(), 5);
  EXPECT_FALSE(waiting.next());
  EXPECT_TRUE(waiting.empty());
}

}  // namespace
}  // namespace chasles
