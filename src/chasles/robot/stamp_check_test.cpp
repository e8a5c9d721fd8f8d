#include <gtest/gtest.h>

#include <chasles/robot/stamp_check.hpp>

namespace chasles {
namespace {

TEST(StampCheck, CountsMessagesWithoutAStamp) {
  StampCheck check;
  EXPECT_TRUE(check.is_set(Time(1), "/imu0"));
  EXPECT_FALSE(check.is_set(Time(0), "/imu0"));
  EXPECT_FALSE(check.is_set(Time(0), "/imu0"));
  EXPECT_EQ(check.unset(), 2u);
}

}  // namespace
}  // namespace chasles
