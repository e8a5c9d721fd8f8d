#include <gtest/gtest.h>

#include <chasles/eval/landmarks.hpp>

namespace chasles {
namespace {

std::vector<MatchedPoint> moved_by(const SE3& truth_T_estimate, const Eigen::Vector3d& error) {
  std::vector<MatchedPoint> points;
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(-4, 0, 1),
                                   Eigen::Vector3d(2, -5, 0), Eigen::Vector3d(0, 1, -3)}) {
    points.push_back({.p_estimate = p, .p_truth = truth_T_estimate * p + error});
  }
  return points;
}

TEST(LandmarkError, IsZeroInTheSameWorld) {
  const SE3 T{so3::exp({0.3, -0.2, 1}), {1, -2, 5}};
  const LandmarkError error = landmark_error(moved_by(T, Eigen::Vector3d::Zero()), T);
  EXPECT_EQ(error.count, 4u);
  EXPECT_NEAR(error.rmse_first_pose_m, 0, 1e-14);
  EXPECT_NEAR(*error.rmse_aligned_m, 0, 1e-13);
}

TEST(LandmarkError, AMapShiftedAsAWholeIsOffByTheShiftUntilItIsAligned) {
  const SE3 T{so3::exp({0.3, -0.2, 1}), {1, -2, 5}};
  const LandmarkError error = landmark_error(moved_by(T, {0.03, 0, 0.04}), T);
  EXPECT_NEAR(error.rmse_first_pose_m, 0.05, 1e-14);
  EXPECT_NEAR(*error.rmse_aligned_m, 0, 1e-13);
}

TEST(LandmarkError, OneWrongPointOfFourCountsHalf) {
  std::vector<MatchedPoint> points = moved_by({}, Eigen::Vector3d::Zero());
  points[2].p_truth += Eigen::Vector3d(0, 0, 2);
  EXPECT_DOUBLE_EQ(landmark_error(points, {}).rmse_first_pose_m, 1);
  EXPECT_GT(*landmark_error(points, {}).rmse_aligned_m, 0.1);
}

TEST(LandmarkError, NoLandmarksHaveNoErrorAndTwoNoAlignment) {
  EXPECT_EQ(landmark_error({}, {}).count, 0u);
  std::vector<MatchedPoint> points = moved_by({}, Eigen::Vector3d::Zero());
  points.resize(2);
  EXPECT_FALSE(landmark_error(points, {}).rmse_aligned_m);
}

}  // namespace
}  // namespace chasles
