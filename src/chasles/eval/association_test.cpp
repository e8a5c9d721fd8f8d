#include <chrono>
#include <cmath>
#include <limits>

#include <chasles/base/error.hpp>
#include <chasles/eval/association.hpp>
#include <chasles/eval/test_trajectories.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using namespace std::chrono_literals;

Trajectory shifted(Trajectory trajectory, Time offset) {
  for (StampedPose& row : trajectory) row.time += offset;
  return trajectory;
}

constexpr TruthPairing kNearest{.pairing = Pairing::kNearest};

TruthPairing within(Time tolerance) {
  return {.pairing = Pairing::kNearest, .tolerance = tolerance};
}

// A turn at constant rate while the centre moves on a straight line: interpolation is exact.
SE3 turning(double t) {
  return {so3::exp(Eigen::Vector3d(0.3, -0.2, 0.9) * t), Eigen::Vector3d(2, -1, 0.5) * t};
}

// Constant twist: a circle of radius |v| / |w| = 2 m.
SE3 on_a_circle(double t) {
  Vector6d twist;
  twist << 0, 0, 0.5, 1, 0, 0;
  return se3::exp(twist * t);
}

template <typename Motion>
Trajectory sampled(const Motion& motion, std::size_t count, Time start, Time spacing) {
  Trajectory trajectory;
  for (std::size_t i = 0; i < count; ++i) {
    const Time time = start + static_cast<long>(i) * spacing;
    trajectory.push_back({time, motion(to_seconds(time))});
  }
  return trajectory;
}

std::string message(const Trajectory& estimate, const Trajectory& truth,
                    const TruthPairing& pairing = {}) {
  try {
    associate(estimate, truth, pairing);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Association, EqualStampsPairUp) {
  const MatchedTrajectories matched = associate(test::helix(20), test::helix(20));
  ASSERT_EQ(matched.estimate.size(), 20U);
  EXPECT_EQ(matched.interpolated, 0U);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(matched.estimate_index[i], i);
    EXPECT_EQ(matched.estimate[i].time, matched.truth[i].time);
  }
}

TEST(Association, TheTruthOfAConstantTurnIsExactBetweenItsStamps) {
  const Trajectory truth = sampled(turning, 60, 0ms, 50ms);
  const Trajectory estimate = sampled(turning, 100, 7ms, 23ms);
  const MatchedTrajectories matched = associate(estimate, truth);
  ASSERT_EQ(matched.truth.size(), 100U);
  EXPECT_EQ(matched.interpolated, 98U);  // 7 + 23 i is a multiple of 50 for i = 41 and 91
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(matched.truth[i].time, estimate[i].time);
    EXPECT_LT((matched.truth[i].pose.p - estimate[i].pose.p).norm(), 1e-13) << i;
    EXPECT_LT((matched.truth[i].pose.R - estimate[i].pose.R).norm(), 1e-13) << i;
  }
}

// The chord of an arc of angle a misses it by r (1 - cos(a / 2)) at most.
TEST(Association, OnAnArcTheTruthMissesByTheHeightOfItsChord) {
  const Trajectory truth = sampled(on_a_circle, 60, 0ms, 50ms);
  const Trajectory estimate = sampled(on_a_circle, 58, 25ms, 50ms);
  const MatchedTrajectories matched = associate(estimate, truth);
  const double height = 2 * (1 - std::cos(0.5 * 0.05 / 2));
  for (std::size_t i = 0; i < matched.truth.size(); ++i) {
    const double miss = (matched.truth[i].pose.p - matched.estimate[i].pose.p).norm();
    EXPECT_NEAR(miss, height, 1e-6 * height);
    EXPECT_LT((matched.truth[i].pose.R - matched.estimate[i].pose.R).norm(), 1e-13);
  }
  // The nearest stamps are up to 25 ms of motion away.
  const MatchedTrajectories nearest =
      associate(sampled(on_a_circle, 58, 24ms, 50ms), truth, kNearest);
  EXPECT_NEAR((nearest.truth[3].pose.p - nearest.estimate[3].pose.p).norm(), 0.024, 1e-5);
}

TEST(Association, AtAStampTheTruthIsThatOfTheStampToTheBit) {
  const Trajectory truth = test::helix(40);
  Trajectory estimate;
  for (std::size_t i = 0; i < 40; i += 3) estimate.push_back({truth[i].time, {}});
  const MatchedTrajectories matched = associate(estimate, truth);
  ASSERT_EQ(matched.truth.size(), estimate.size());
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    EXPECT_EQ(matched.truth[i].pose.p, truth[3 * i].pose.p);
    EXPECT_EQ(matched.truth[i].pose.R, truth[3 * i].pose.R);
  }
}

TEST(Association, TheLongestGapIsAnOption) {
  const Trajectory truth = sampled(turning, 10, 0ms, 500ms);
  const Trajectory estimate = sampled(turning, 40, 10ms, 100ms);
  EXPECT_NE(message(estimate, truth).find("its poses are 0.5 s apart; a longer gap"),
            std::string::npos)
      << message(estimate, truth);
  EXPECT_EQ(associate(estimate, truth, {.longest_gap = 500ms}).truth.size(), 40U);
  EXPECT_NE(message(estimate, truth, {.longest_gap = 499ms}), "no error");
}

TEST(Association, ASlowTruthTakesTheNearestOfAFastEstimate) {
  Trajectory estimate;
  for (int i = 0; i < 1000; ++i) estimate.push_back({i * 5ms + 1ms, {}});
  const MatchedTrajectories matched = associate(estimate, test::helix(40), kNearest);
  ASSERT_EQ(matched.truth.size(), 40U);
  for (std::size_t i = 0; i < 40; ++i) {
    EXPECT_EQ(matched.estimate[i].time - matched.truth[i].time, 1ms);
    EXPECT_EQ(matched.estimate_index[i], 20 * i);
  }
}

TEST(Association, NoPoseIsUsedTwice) {
  Trajectory estimate = test::helix(20);
  estimate.insert(estimate.begin() + 5, {estimate[4].time + 10ms, {}});
  const MatchedTrajectories matched = associate(estimate, test::helix(20), kNearest);
  EXPECT_EQ(matched.truth.size(), 20U);
  EXPECT_EQ(matched.estimate_index[4], 4U);
  EXPECT_EQ(matched.estimate_index[5], 6U);
}

TEST(Association, PosesWithinAGapStayAlone) {
  Trajectory truth = test::helix(30);
  truth.erase(truth.begin() + 10, truth.begin() + 20);
  EXPECT_EQ(associate(test::helix(30), truth).truth.size(), 20U);
  EXPECT_EQ(associate(test::helix(30), truth, kNearest).truth.size(), 20U);
}

TEST(Association, TheToleranceIsAnOption) {
  const Trajectory late = shifted(test::helix(20), 30ms);
  EXPECT_EQ(associate(late, test::helix(20), kNearest).truth.size(), 20U);
  EXPECT_EQ(associate(late, test::helix(20), within(30ms)).truth.size(), 20U);
  EXPECT_THROW(associate(late, test::helix(20), within(29ms)), InputError);
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
