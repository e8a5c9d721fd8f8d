#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/live/comparison.hpp>
#include <chasles/report/testing.hpp>

namespace chasles {
namespace {

TEST(GrowingComparison, StatesThatAreNotFiniteLeaveThatOfTheOthers) {
  auto run = test::synthetic_drive({.states = 40, .landmarks = 0, .dead_reckoning = false}).run;
  for (const std::size_t lost : std::vector<std::size_t>{0, 20}) {
    run.states[lost].world_T_imu.p.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  GrowingComparison growing(run.truth, run.pairing, PoseError::kStandard, false);
  growing.extend(run.states);
  ASSERT_TRUE(growing.started());
  std::vector<std::size_t> all(run.states.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  const AgainstTruth live = growing.of(all), whole = against_truth(run);
  for (const std::size_t i : all) {
    EXPECT_EQ(live.error[i].allFinite(), i != 0 && i != 20) << i;
    if (live.error[i].allFinite()) {
      EXPECT_LT((live.error[i] - whole.error[i]).norm(), 1e-12) << i;
    }
  }
}

}  // namespace
}  // namespace chasles
