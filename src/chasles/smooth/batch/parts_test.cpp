#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/smooth/batch/parts_detail.hpp>

namespace chasles::smooth_detail {
namespace {

struct Seen {
  int keyframe = 0, camera = 0;
  bool operator==(const Seen&) const = default;
};

using Parts = std::vector<std::vector<Seen>>;

// One observation per keyframe; `x` where the gate rejects it.
Parts parts_of(const std::string& observations, int max_rejections) {
  std::vector<Seen> views;
  std::vector<double> whitened_norms;
  for (const char each : observations) {
    views.push_back({.keyframe = static_cast<int>(views.size())});
    whitened_norms.push_back(each == 'x' ? 6 : 1);
  }
  return parts_that_agree(views, whitened_norms, 5, max_rejections);
}

TEST(PartsThatAgree, AreSplitBySoManyRejectionsInARow) {
  EXPECT_EQ(parts_of("..xx.", 3), (Parts{{{0}, {1}, {4}}}));
  EXPECT_EQ(parts_of("..xxx.", 3), (Parts{{{0}, {1}}, {{5}}}));
  EXPECT_EQ(parts_of(".xxx.x.xxxx..", 3), (Parts{{{0}}, {{4}, {6}}, {{11}, {12}}}));
  EXPECT_EQ(parts_of("..xxx.", 0), (Parts{{{0}, {1}, {5}}}));
}

TEST(PartsThatAgree, WhatIsRejectedAtTheEndsSplitsNothing) {
  EXPECT_EQ(parts_of("xxx..", 3), (Parts{{{3}, {4}}}));
  EXPECT_EQ(parts_of("..xxx", 3), (Parts{{{0}, {1}}}));
  EXPECT_EQ(parts_of("xxx", 3), Parts(1));
  EXPECT_EQ(parts_of("", 3), Parts(1));
}

TEST(PartsThatAgree, NotANumberDoesNot) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(parts_that_agree(std::vector<Seen>{{0}, {1}}, std::vector{nan, 1.0}, 5, 3),
            (Parts{{{1}}}));
}

// A keyframe rejects a landmark where none of its cameras agrees. The order of the views within a
// keyframe does not matter.
TEST(PartsThatAgree, KeyframesCountNotObservations) {
  const std::vector<Seen> views{{0, 0}, {0, 1}, {3, 0}, {3, 1}, {9, 0}, {9, 1}, {12, 0}, {12, 1}};
  const auto parts = [&](const std::vector<double>& whitened_norms) {
    return parts_that_agree(views, whitened_norms, 5, 2);
  };
  EXPECT_EQ(parts({1, 1, 9, 9, 9, 9, 9, 1}), (Parts{{{0, 0}, {0, 1}}, {{12, 1}}}));
  EXPECT_EQ(parts({1, 1, 9, 9, 1, 9, 9, 1}), (Parts{{{0, 0}, {0, 1}, {9, 0}, {12, 1}}}));
  EXPECT_EQ(parts({1, 9, 9, 1, 9, 9, 1, 1}), (Parts{{{0, 0}, {3, 1}, {12, 0}, {12, 1}}}));
}

}  // namespace
}  // namespace chasles::smooth_detail
