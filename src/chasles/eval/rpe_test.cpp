#include <chasles/base/error.hpp>
#include <chasles/eval/rpe.hpp>
#include <chasles/eval/test_trajectories.hpp>

namespace chasles {
namespace {

const RelativeErrorOptions kEvery{
    .distances_m = {100, 200, 800}, .intervals_s = {1, 10}, .step = 1};

TEST(RelativeError, AScaleErrorOfOnePercentIsOnePercent) {
  const Trajectory truth = test::straight(10000, 0.1);
  Trajectory estimate = truth;
  for (StampedPose& row : estimate) row.pose.p *= 1.01;
  for (const RelativeError& e : relative_error_over_distance(associate(estimate, truth), kEvery)) {
    // A piece is longer than its length by up to one step of 0.1 m.
    EXPECT_NEAR(e.translation.mean, 1, 0.1 / e.length + 1e-9) << e.length;
    EXPECT_NEAR(e.translation.rmse, e.translation.mean, 2e-3);
    EXPECT_NEAR(e.rotation.max, 0, 1e-9);
  }
}

TEST(RelativeError, AHeadingDriftIsMeasuredPerMetreAndBendsThePath) {
  // The estimate rotates by 0.01 deg per metre of a straight truth: over L the end is off by |(sin
  // a / a - 1, (1 - cos a) / a)| L with a the angle of rotation.
  const double rate = 0.01 * std::numbers::pi / 180;
  const Trajectory truth = test::straight(20000, 0.1);
  Trajectory estimate = truth;
  for (StampedPose& row : estimate) {
    const double a = rate * row.pose.p.x();
    row.pose = {so3::exp({0, 0, a}), {std::sin(a) / rate, (1 - std::cos(a)) / rate, 0}};
  }
  for (const RelativeError& e : relative_error_over_distance(associate(estimate, truth), kEvery)) {
    const double a = rate * e.length;
    const double expected = 100 * std::hypot(std::sin(a) / a - 1, (1 - std::cos(a)) / a);
    EXPECT_NEAR(e.translation.mean, expected, 3e-3 * expected) << e.length;
    EXPECT_NEAR(e.rotation.mean, 0.01, 2e-5) << e.length;
  }
}

TEST(RelativeError, DoesNotDependOnTheWorlds) {
  test::Random random(41);
  const Trajectory truth = test::helix(300);
  Trajectory estimate = truth;
  for (StampedPose& row : estimate) row.pose.p += random.normal_vector(3);
  const auto reference = relative_error_over_distance(associate(estimate, truth));
  const auto moved =
      relative_error_over_distance(associate(test::moved(test::some_transform(), estimate), truth));
  for (std::size_t i = 0; i < reference.size(); ++i) {
    EXPECT_GT(reference[i].translation.mean, 0.1);
    EXPECT_NEAR(moved[i].translation.mean, reference[i].translation.mean, 1e-10);
  }
}

TEST(RelativeError, PiecesStartEveryStepAndEndPastTheLength) {
  // Poses at 0, 1, ..., 150 m: a piece over 100 m needs 101 m, so that starts 0 to 49 have one.
  const Trajectory truth = test::straight(151, 1.0);
  const auto count = [&](int step) {
    const RelativeErrorOptions options{.distances_m = {100}, .intervals_s = {}, .step = step};
    return relative_error_over_distance(associate(truth, truth), options)[0].translation.count;
  };
  EXPECT_EQ(count(1), 50U);
  EXPECT_EQ(count(10), 5U);
  EXPECT_EQ(count(7), 8U);
}

TEST(RelativeError, ALengthBeyondThePathHasNoPieces) {
  const Trajectory truth = test::straight(151, 1.0);
  const auto errors = relative_error_over_distance(associate(truth, truth));
  ASSERT_EQ(errors.size(), 8U);
  EXPECT_EQ(errors[1].length, 200);
  EXPECT_EQ(errors[1].translation.count, 0U);
  EXPECT_TRUE(std::isnan(errors[1].translation.mean));
}

TEST(RelativeError, AStaticBodyHasTimesButNoDistances) {
  const Trajectory standstill = test::straight(151, 0);
  const MatchedTrajectories matched = associate(standstill, standstill);
  EXPECT_EQ(relative_error_over_distance(matched)[0].translation.count, 0U);
  EXPECT_EQ(relative_error_over_time(matched)[0].translation.max, 0);
}

TEST(RelativeError, ASpeedErrorIsMetresOverATime) {
  const Trajectory truth = test::straight(300, 1.0);
  Trajectory estimate = truth;
  for (StampedPose& row : estimate) row.pose.p.x() *= 1.02;
  const auto errors = relative_error_over_time(associate(estimate, truth), kEvery);
  EXPECT_NEAR(errors[0].translation.mean, 0.2, 1e-12);
  EXPECT_NEAR(errors[1].translation.mean, 2.0, 1e-12);
  EXPECT_EQ(errors[0].translation.count, 290U);
  EXPECT_EQ(errors[1].translation.count, 200U);
}

TEST(RelativeError, OverATimeSkipsPiecesThatEndInAGap) {
  Trajectory truth = test::straight(100, 1.0);
  truth.erase(truth.begin() + 40, truth.begin() + 60);
  const RelativeErrorOptions options{.distances_m = {}, .intervals_s = {1}, .step = 1};
  const auto errors = relative_error_over_time(associate(truth, truth), options);
  EXPECT_EQ(errors[0].translation.count, 30U + 30U);
}

TEST(RelativeError, RejectsLengthsAndStepsThatAreNotPositive) {
  const Trajectory truth = test::helix(10);
  const MatchedTrajectories matched = associate(truth, truth);
  const auto over = [&](RelativeErrorOptions options) {
    relative_error_over_distance(matched, options);
    relative_error_over_time(matched, options);
  };
  EXPECT_THROW(over({.distances_m = {100}, .intervals_s = {}, .step = 0}), UsageError);
  EXPECT_THROW(over({.distances_m = {-1}, .intervals_s = {}, .step = 1}), UsageError);
  EXPECT_THROW(over({.distances_m = {}, .intervals_s = {0}, .step = 1}), UsageError);
}

}  // namespace
}  // namespace chasles
