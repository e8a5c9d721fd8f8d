#include <gtest/gtest.h>

#include <chasles/recording/pair_images.hpp>

namespace chasles {
namespace {

std::vector<Time> milliseconds(std::initializer_list<int> list) {
  std::vector<Time> times;
  for (const int ms : list) times.push_back(std::chrono::milliseconds(ms));
  return times;
}

constexpr Time kTolerance = std::chrono::milliseconds(2);

TEST(PairImages, OfACameraThatFindsTracksBecomeFramesOfTheirOwn) {
  std::vector<std::string> remarks;
  const auto frames = pair_images(
      {milliseconds({0, 50, 100}), milliseconds({1, 25, 75, 101}), milliseconds({26, 130})},
      {true, true, true}, kTolerance, remarks);
  ASSERT_EQ(frames.size(), 6u);
  const std::vector<int> times = {0, 25, 50, 75, 100, 130};
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_EQ(frames[i].time, std::chrono::milliseconds(times[i]));
  }
  EXPECT_EQ(frames[0].members[1], 0u);
  EXPECT_FALSE(frames[1].members[0]);
  EXPECT_EQ(frames[1].members[1], 1u);
  EXPECT_EQ(frames[1].members[2], 0u) << "joins the frame of the camera before it";
  EXPECT_EQ(frames[5].members[2], 1u);
  ASSERT_EQ(remarks.size(), 2u);
  EXPECT_NE(remarks[0].find("2 of the 4 images of cam1"), std::string::npos) << remarks[0];
  EXPECT_NE(remarks[1].find("1 of the 2 images of cam2"), std::string::npos) << remarks[1];
}

TEST(PairImages, OfACameraThatOnlyMatchesAreLeftOutAndCounted) {
  std::vector<std::string> remarks;
  const auto frames = pair_images({milliseconds({0, 50}), milliseconds({1, 25, 51})}, {true, false},
                                  kTolerance, remarks);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1].members[1], 2u);
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_NE(remarks[0].find("left out"), std::string::npos) << remarks[0];
}

}  // namespace
}  // namespace chasles
