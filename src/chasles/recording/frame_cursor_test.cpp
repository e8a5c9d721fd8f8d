#include <gtest/gtest.h>

#include <chasles/recording/frame_cursor.hpp>

namespace chasles {
namespace {

class FrameCursorOverThree : public ::testing::Test {
 protected:
  std::vector<FeatureFrame> frames{{.time = Time(10)}, {.time = Time(20)}, {.time = Time(30)}};
  FrameCursor cursor{frames};
};

TEST_F(FrameCursorOverThree, AFrameMayHaveManyRowsOrNone) {
  EXPECT_EQ(cursor.find(Time(10)), &frames[0]);
  EXPECT_EQ(cursor.find(Time(10)), &frames[0]);
  EXPECT_EQ(cursor.find(Time(30)), &frames[2]);
}

TEST_F(FrameCursorOverThree, FindsNothingBetweenAndAfterTheFrames) {
  EXPECT_EQ(cursor.find(Time(5)), nullptr);
  EXPECT_EQ(cursor.find(Time(15)), nullptr);
  EXPECT_EQ(cursor.find(Time(20)), &frames[1]) << "it goes on after a time without a frame";
  EXPECT_EQ(cursor.find(Time(31)), nullptr);
  EXPECT_EQ(cursor.find(Time(30)), nullptr);
}

TEST_F(FrameCursorOverThree, DoesNotGoBack) {
  EXPECT_EQ(cursor.find(Time(20)), &frames[1]);
  EXPECT_EQ(cursor.find(Time(10)), nullptr);
}

}  // namespace
}  // namespace chasles
