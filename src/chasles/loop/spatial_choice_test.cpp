#include <algorithm>

#include <gtest/gtest.h>

#include <chasles/lie/testing.hpp>
#include <chasles/loop/spatial_choice.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

TEST(SpatialChoice, OneInEachPartOfSpaceAndFromEachSide) {
  SpatialChoice choice(100);
  const Vector3f from(1, 0, 0), from_behind(-1, 0, 0);
  EXPECT_TRUE(choice.choose(1, {0.1, 0.1, 0.1}, 5, from));
  EXPECT_FALSE(choice.choose(2, {0.2, 0.1, 0.1}, 5, from));
  EXPECT_TRUE(choice.choose(1, {0.1, 0.1, 0.1}, 5, from)) << "it has been chosen";
  EXPECT_TRUE(choice.choose(3, {0.2, 0.1, 0.1}, 5, from_behind));
  EXPECT_TRUE(choice.choose(4, {9, 0.1, 0.1}, 5, from));
  EXPECT_TRUE(choice.choose(5, {0.2, 0.1, 0.1}, 0.5, from)) << "from near, the parts are smaller";
  EXPECT_FALSE(choice.choose(6, {std::nan(""), 0, 0}, 5, from));
  EXPECT_EQ(choice.size(), 4);
  choice.give_up(1);
  choice.give_up(7);
  EXPECT_EQ(choice.size(), 3);
  EXPECT_TRUE(choice.choose(2, {0.2, 0.1, 0.1}, 5, from)) << "its place is free";
}

TEST(SpatialChoice, ThinsOutEvenly) {
  SpatialChoice choice(200);
  test::Random random(1);
  for (int i = 0; i < 4000; ++i) {
    choice.choose(i, 50 * Vector3d(random.uniform(), random.uniform(), 0), 2, {0, 0, 1});
  }
  const int before = choice.size();
  ASSERT_GT(before, 1000);
  const std::vector<LandmarkId> dropped = choice.thin();
  EXPECT_EQ(static_cast<int>(dropped.size()), before - choice.size());
  EXPECT_LE(choice.size(), 200);
  EXPECT_GT(choice.size(), 50);
  EXPECT_TRUE(choice.choose(0, {}, 1, {0, 0, 1})) << "the oldest stay";
  EXPECT_TRUE(choice.thin().empty());
}

}  // namespace
}  // namespace chasles
