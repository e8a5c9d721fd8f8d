#include <gtest/gtest.h>

#include <chasles/estimate/health.hpp>

namespace chasles {
namespace {

Time frame_time(int frame) { return frame * std::chrono::milliseconds(100); }

TEST(RecentUse, DegradesAnEstimateWithoutObservationsAndOneThatRejectsMost) {
  RecentUse recent;
  EXPECT_EQ(recent.assess(frame_time(0), 2, 0, 2, 4), Degradation::kFewObservations);
  EXPECT_EQ(recent.assess(frame_time(1), 2, 5, 2, 4), Degradation::kRejections);
  EXPECT_EQ(recent.assess(frame_time(2), 20, 0, 40, 40), Degradation::kNone);
}

TEST(RecentUse, DegradesInnovationsThatContradictTheirCovarianceForASecond) {
  RecentUse recent;
  for (int k = 0; k < 20; ++k) {
    EXPECT_EQ(recent.assess(frame_time(k), 20, 0, 44, 40), Degradation::kNone) << k;
  }
  // NIS of 608 per degree of freedom: a filter without a gate that has gone astray.
  int degraded = 0;
  for (int k = 20; k < 30; ++k) {
    degraded +=
        recent.assess(frame_time(k), 20, 0, 608 * 40, 40) == Degradation::kInnovations ? 1 : 0;
  }
  EXPECT_EQ(degraded, 10);
  int after = 0;
  for (int k = 30; k < 50; ++k) {
    after += recent.assess(frame_time(k), 20, 0, 40, 40) == Degradation::kInnovations ? 1 : 0;
  }
  EXPECT_EQ(after, 10) << "for one second after the last of them";
}

// Three degrees of freedom exceed twice their number with a probability of 11 %.
TEST(RecentInnovations, FewDegreesOfFreedomNeedMoreThanTwiceTheirNumber) {
  RecentInnovations recent;
  EXPECT_FALSE(recent.contradict(frame_time(0), 10, 3));
  EXPECT_FALSE(recent.contradict(frame_time(20), 0, 0));
  EXPECT_TRUE(recent.contradict(frame_time(40), 17, 3));  // 99.9 %: 16.3
}

}  // namespace
}  // namespace chasles
