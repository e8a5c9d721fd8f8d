#include <chasles/loop/placed_map.hpp>
#include <chasles/loop/run_in_map_testing.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct InMap {
  NavState now;
  PoseInMap pose;
};

InMap in_map(const test::RunInMap& run) {
  NavScratch scratch;
  find_nav_derivative(run.filter.state(), scratch);
  const NavState now = nav_state(run.filter, scratch);
  return {now, run.placed.pose_in_map(run.filter, now, scratch.derivative)};
}

// What the run measures corrects the frame of the map as the textbook filter does.
TEST(PlacedMap, ItsFrameIsThatOfTheTextbookFilter) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const test::RunInMap run(seed);
    const SE3 expected = run.frame(VectorXd::Zero(run.P.rows()));
    ASSERT_GT(test::distance(expected, run.nav_T_map), 1e-3) << "nothing has been corrected";
    EXPECT_LT(test::distance(run.placed.nav_T_map(run.filter), expected), 1e-9);
    EXPECT_LT(test::distance(in_map(run).pose.world_T_map, expected), 1e-9);
  }
}

// The covariance is that of the joint errors of pose and map, by numeric derivatives.
TEST(PlacedMap, ThePoseInItHasTheErrorsOfBoth) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const test::RunInMap run(seed);
    const InMap found = in_map(run);
    const SE3& map_T_imu = found.pose.map_T_imu;
    const VectorXd zero = VectorXd::Zero(run.P.rows());
    EXPECT_LT(test::distance(map_T_imu, run.frame(zero).inverse() * found.now.nav_T_imu), 1e-9);
    const auto error = [&](const VectorXd& e) -> VectorXd {
      SE3 nav_T_imu = found.now.nav_T_imu;
      nav_T_imu.R = so3::exp(e.head<3>()) * nav_T_imu.R;
      nav_T_imu.p += e.segment<3>(3);
      const SE3 there = run.frame(e).inverse() * nav_T_imu;
      VectorXd xi(6);
      xi << so3::log(there.R * map_T_imu.R.transpose()), there.p - map_T_imu.p;
      return xi;
    };
    const MatrixXd J = test::numeric_derivative(error, zero, 1e-4);
    const MatrixXd expected = J * run.P * J.transpose();
    EXPECT_LT(test::covariance_difference(found.pose.covariance, expected), 1e-6);
    const MatrixXd alone =
        J.leftCols<15>() * run.P.topLeftCorner<15, 15>() * J.leftCols<15>().transpose();
    EXPECT_GT(test::covariance_difference(alone, expected), 0.01) << "the map says nothing";
  }
}

}  // namespace
}  // namespace chasles
