#include <chrono>
#include <limits>

#include <chasles/error.hpp>
#include <chasles/eval/association.hpp>
#include <chasles/eval/test_trajectories.hpp>

namespace chasles {
namespace {

using namespace std::chrono_literals;

Trajectory shifted(Trajectory trajectory, Time offset) {
  for (StampedPose& row : trajectory) row.time += offset;
  return trajectory;
}

std::string message(const Trajectory& estimate, const Trajectory& truth) {
  try {
    associate(estimate, truth);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Association, EqualStampsPairUp) {
  const MatchedTrajectories matched = associate(test::helix(20), test::helix(20));
  ASSERT_EQ(matched.estimate.size(), 20U);
  EXPECT_EQ(matched.tolerance, 50ms);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(matched.estimate_index[i], i);
    EXPECT_EQ(matched.estimate[i].time, matched.truth[i].time);
  }
}

TEST(Association, ASlowTruthTakesTheNearestOfAFastEstimate) {
  Trajectory estimate;
  for (int i = 0; i < 1000; ++i) estimate.push_back({i * 5ms + 1ms, {}});
  const MatchedTrajectories matched = associate(estimate, test::helix(40));
  ASSERT_EQ(matched.truth.size(), 40U);
  for (std::size_t i = 0; i < 40; ++i) {
    EXPECT_EQ(matched.estimate[i].time - matched.truth[i].time, 1ms);
    EXPECT_EQ(matched.estimate_index[i], 20 * i);
  }
}

TEST(Association, NoPoseIsUsedTwice) {
  Trajectory estimate = test::helix(20);
  estimate.insert(estimate.begin() + 5, {estimate[4].time + 10ms, {}});
  const MatchedTrajectories matched = associate(estimate, test::helix(20));
  EXPECT_EQ(matched.truth.size(), 20U);
  EXPECT_EQ(matched.estimate_index[4], 4U);
  EXPECT_EQ(matched.estimate_index[5], 6U);
}

TEST(Association, PosesWithinAGapStayAlone) {
  Trajectory truth = test::helix(30);
  truth.erase(truth.begin() + 10, truth.begin() + 20);
  EXPECT_EQ(associate(test::helix(30), truth).truth.size(), 20U);
}

TEST(Association, TheToleranceIsAnOption) {
  const Trajectory late = shifted(test::helix(20), 30ms);
  EXPECT_EQ(associate(late, test::helix(20)).truth.size(), 20U);
  EXPECT_EQ(associate(late, test::helix(20), 30ms).truth.size(), 20U);
  EXPECT_THROW(associate(late, test::helix(20), 29ms), InputError);
}

TEST(Association, WithoutOverlapTheErrorSaysTheRanges) {
  const std::string text = message(shifted(test::helix(20), 1h), test::helix(30));
  EXPECT_NE(text.find("20 poses from 3600.000 to 3601.900 s"), std::string::npos) << text;
  EXPECT_NE(text.find("30 poses from 0.000 to 2.900 s"), std::string::npos) << text;
}

TEST(Association, EmptyOrTooShortIsAnError) {
  EXPECT_NE(message({}, test::helix(20)).find("no poses"), std::string::npos);
  EXPECT_NE(message(test::helix(20), {}).find("no poses"), std::string::npos);
  EXPECT_NE(message(test::helix(1), test::helix(1)).find("only 1 poses"), std::string::npos);
  EXPECT_NE(message(test::helix(2), test::helix(20)).find("only 2 poses"), std::string::npos);
}

TEST(Association, APoseThatIsNotFiniteIsNamed) {
  Trajectory broken = test::helix(20);
  broken[7].pose.p.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message(broken, test::helix(20)).find("estimate: pose 7"), std::string::npos);
  broken = test::helix(20);
  broken[3].pose.R(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_NE(message(test::helix(20), broken).find("truth: pose 3"), std::string::npos);
}

TEST(Association, StampsThatDoNotIncreaseAreNamed) {
  Trajectory broken = test::helix(20);
  broken[8].time = broken[7].time;
  EXPECT_NE(message(broken, test::helix(20)).find("of pose 8"), std::string::npos);
}

TEST(Association, DistancesAreThoseOfTheChords) {
  const Trajectory trajectory = test::straight(11, 2.5);
  EXPECT_DOUBLE_EQ(path_length(trajectory), 25);
  EXPECT_DOUBLE_EQ(distances_along(trajectory)[4], 10);
  EXPECT_EQ(path_length({}), 0);
  EXPECT_EQ(median_spacing(trajectory), 100ms);
  EXPECT_EQ(median_spacing({}), 0ms);
}

}  // namespace
}  // namespace chasles
