#include <array>

#include <gtest/gtest.h>

#include <chasles/loop/landmark_map.hpp>
#include <chasles/loop/map_testing.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

// By moving the frame and the points, and looking where they are then.
TEST(PlacedMap, ItsErrorsAreThoseOfTheMapAndOfItsPlace) {
  const LandmarkMap map = test::corridor_map(1, 8, 10);
  const SE3 world_T_map = test::level_pose(0.7, {1, -2, 3});
  const std::array points{5, 0, 3};
  const Vector3d pivot(5, 6, 7);
  const PriorMap prior = placed(
      map, points,
      {.world_T_map = world_T_map, .pivot = pivot, .heading_sigma = 0.2, .position_sigma = 3});
  ASSERT_EQ(prior.landmarks.size(), 3u);
  const Eigen::Index r = map.covariance.rank();
  ASSERT_EQ(prior.shared.cols(), r + 4);
  constexpr double kStep = 1e-6;
  for (Eigen::Index column = 0; column < r + 4; ++column) {
    Eigen::VectorXd y = Eigen::VectorXd::Zero(r + 4);
    y(column) = kStep;
    const SE3 turn = test::level_pose(0.2 * y(r), Vector3d::Zero());
    const SE3 moved{turn.R * world_T_map.R,
                    pivot + turn.R * (world_T_map.p - pivot) + 3 * y.tail<3>()};
    EXPECT_NEAR(prior.shared(2, column), column == r ? 0.2 : 0, 1e-12);
    EXPECT_TRUE(test::agree(prior.shared.block<3, 1>(3, column), (moved.p - world_T_map.p) / kStep,
                            1e-6, 1e-6));
    for (int i = 0; i < 3; ++i) {
      const int point = points[static_cast<std::size_t>(i)];
      const Vector3d p_map = map.points[static_cast<std::size_t>(point)].p_map +
                             map.covariance.shared().middleRows<3>(3 * point) * y.head(r);
      const Vector3d& before = prior.landmarks[static_cast<std::size_t>(i)].p_world;
      EXPECT_TRUE(test::agree(prior.shared.block<3, 1>(6 + 3 * i, column),
                              (moved * p_map - before) / kStep, 1e-6, 1e-5));
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(prior.landmarks[i].id, kFirstMapId + points[i]);
    const Eigen::Matrix3d& own = map.covariance.own()[static_cast<std::size_t>(points[i])];
    EXPECT_TRUE(
        test::agree(prior.own[i], world_T_map.R * own * world_T_map.R.transpose(), 1e-12, 0));
  }
}

}  // namespace
}  // namespace chasles
