#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/eval/positions_only.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr std::size_t kRows = 200, kWrong = 50;
constexpr double kHigh = 0.3, kSigma = 0.1;

// A circle, and the positions of its truth in another world; one estimate is too high by kHigh.
MatchedTrajectories circle() {
  const SE3 truth_T_estimate{so3::exp(Eigen::Vector3d(0, 0, 1.1)), {3, -2, 0.5}};
  MatchedTrajectories matched;
  for (std::size_t i = 0; i < kRows; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / kRows;
    const Time time = std::chrono::milliseconds(10 * i);
    SE3 pose{so3::exp(Eigen::Vector3d(0, 0, angle)), {2 * std::cos(angle), 2 * std::sin(angle), 1}};
    matched.truth.push_back({time, {Eigen::Matrix3d::Identity(), truth_T_estimate * pose.p}});
    if (i == kWrong) pose.p.z() += kHigh;
    matched.estimate.push_back({time, pose});
    matched.estimate_index.push_back(i);
  }
  return matched;
}

TEST(PositionsOnly, AreATruthThatDoesNotTurnWhileTheEstimateDoes) {
  const MatchedTrajectories matched = circle();
  EXPECT_TRUE(is_without_attitudes(matched.estimate, matched.truth));
  EXPECT_FALSE(is_without_attitudes(matched.truth, matched.truth)) << "the estimate turns, too";
  EXPECT_FALSE(is_without_attitudes(matched.estimate, matched.estimate));
  EXPECT_FALSE(is_without_attitudes(matched.estimate, {}));
}

TEST(PositionsOnly, HaveTheNeesOfThePositionAndNoOther) {
  const MatchedTrajectories matched = circle();
  const std::vector<Matrix6d> covariances(kRows, kSigma * kSigma * Matrix6d::Identity());
  const Nees nees = position_nees(matched, covariances, true);
  ASSERT_EQ(nees.position.size(), kRows);
  for (std::size_t i = 0; i < kRows; ++i) {
    EXPECT_NEAR(nees.position[i], i == kWrong ? std::pow(kHigh / kSigma, 2) : 0, 1e-9) << i;
    EXPECT_TRUE(std::isnan(nees.attitude[i]) && std::isnan(nees.pose[i])) << i;
  }
  EXPECT_EQ(nees.position_summary.count, kRows);
  EXPECT_EQ(nees.attitude_summary.count + nees.pose_summary.count, 0U);
  const SigmaShares& shares = nees.within_3_sigma;
  EXPECT_EQ(shares.count, (std::array<std::size_t, 6>{0, 0, 0, kRows, kRows, kRows}));
  EXPECT_TRUE(std::isnan(shares.share[0]));
  EXPECT_DOUBLE_EQ(shares.share[3], 1);
  EXPECT_EQ(position_nees({}, covariances, true).position.size(), 0U);
}

}  // namespace
}  // namespace chasles
