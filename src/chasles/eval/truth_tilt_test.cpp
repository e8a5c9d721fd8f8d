#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/eval/ate.hpp>
#include <chasles/eval/test_trajectories.hpp>
#include <chasles/eval/truth_tilt.hpp>

namespace chasles {
namespace {

const Eigen::Vector3d kHorizontal = Eigen::Vector3d(3, -1, 0).normalized();

Eigen::Matrix3d tilted(double degrees) { return so3::exp(degrees / kDegrees * kHorizontal); }

TEST(TruthTilt, OfATurnedWorldIsItsAngle) {
  const Trajectory estimate = test::helix(200);
  for (const double degrees : {1e-4, 0.5, 3.0, 40.0, 170.0}) {
    // Before the tilt the world is turned about the vertical and moved: both stay.
    const SE3 turned{so3::exp({0, 0, 2.1}), Eigen::Vector3d(20, 5, -3)};
    const SE3 leaning{tilted(degrees), Eigen::Vector3d::Zero()};
    Trajectory truth = test::moved(leaning * turned, estimate);
    const TruthTilt tilt = turn_to_level(truth, estimate);
    EXPECT_NEAR(tilt.degrees, degrees, 1e-9);
    EXPECT_TRUE(test::agree(tilt.level_R_truth, leaning.R.transpose(), 1e-11)) << degrees;
    const Trajectory level = test::moved(turned, estimate);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      EXPECT_TRUE(test::agree(truth[i].pose.R, level[i].pose.R, 1e-10));
      EXPECT_TRUE(test::agree(truth[i].pose.p, level[i].pose.p, 1e-8));
    }
  }
}

TEST(TruthTilt, OfALevelWorldIsZero) {
  const SE3 turned{so3::exp({0, 0, -0.7}), Eigen::Vector3d(1, 2, 3)};
  Trajectory truth = test::moved(turned, test::helix(100));
  const Trajectory before = truth;
  EXPECT_LT(turn_to_level(truth, test::helix(100)).degrees, 1e-12);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_TRUE(test::agree(truth[i].pose.p, before[i].pose.p, 1e-11));
  }
}

// On a straight line positions leave the rotation about the line open; attitudes do not.
TEST(TruthTilt, AboutTheDirectionOfTravelIsFoundOnAStraightLine) {
  const Trajectory estimate = test::straight(50, 1.0);
  Trajectory truth = test::moved({so3::exp({0.05, 0, 0}), Eigen::Vector3d::Zero()}, estimate);
  EXPECT_NEAR(turn_to_level(truth, estimate).degrees, 0.05 * kDegrees, 1e-9);
  EXPECT_NEAR(absolute_error(associate(estimate, truth), Alignment::kPositionYaw).attitude_deg.max,
              0, 1e-6);
}

TEST(TruthTilt, NeedsPairs) {
  EXPECT_EQ(truth_tilt({}).degrees, 0);
  Trajectory truth = test::helix(10);
  for (StampedPose& row : truth) row.time += from_seconds(1000);
  EXPECT_THROW(turn_to_level(truth, test::helix(10)), InputError);
}

TEST(TruthTilt, ATruthRelativeToItsFirstPoseBeginsAtTheIdentity) {
  Trajectory truth = test::straight(3, 1.0);
  EXPECT_TRUE(begins_at_identity(truth));
  truth[0].pose.p.x() = 1.1e-7;  // as in a file of KITTI's odometry
  EXPECT_TRUE(begins_at_identity(truth));
  truth[0].pose.p.x() = 1e-3;
  EXPECT_FALSE(begins_at_identity(truth));
  truth[0].pose = {so3::exp({0, 0, 1e-4}), Eigen::Vector3d::Zero()};
  EXPECT_FALSE(begins_at_identity(truth));
  EXPECT_FALSE(begins_at_identity({}));
}

}  // namespace
}  // namespace chasles
