#include <Eigen/Geometry>

#include <chasles/eval/ate.hpp>
#include <chasles/eval/test_trajectories.hpp>

namespace chasles {
namespace {

constexpr double kTight = 1e-11;

MatchedTrajectories match(const Trajectory& estimate, const Trajectory& truth) {
  return associate(estimate, truth);
}

::testing::AssertionResult same(const SE3& a, const SE3& b, double tolerance) {
  const auto rotation = test::agree(a.R, b.R, tolerance);
  return rotation ? test::agree(a.p, b.p, tolerance) : rotation;
}

TEST(Alignment, RigidAndFirstPoseRecoverAKnownTransform) {
  const SE3 transform = test::some_transform();
  const Trajectory estimate = test::helix(200);
  const MatchedTrajectories matched = match(estimate, test::moved(transform, estimate));
  for (const Alignment kind : {Alignment::kRigid, Alignment::kFirstPose, Alignment::kSimilarity}) {
    const WorldAlignment found = align(matched, kind);
    EXPECT_TRUE(same(found.truth_T_estimate, transform, kTight)) << name(kind);
    EXPECT_NEAR(found.scale, 1, kTight);
    EXPECT_EQ(found.rank, 2);
    EXPECT_LT(absolute_error(matched, kind).position_m.max, 1e-9);
    EXPECT_LT(absolute_error(matched, kind).attitude_deg.max, 1e-9);
  }
}

TEST(Alignment, PositionYawRecoversATurnAboutTheVertical) {
  const SE3 transform{so3::exp({0, 0, -2.5}), {100, 20, -3}};
  const Trajectory estimate = test::helix(200);
  const MatchedTrajectories matched = match(estimate, test::moved(transform, estimate));
  EXPECT_TRUE(same(align(matched, Alignment::kPositionYaw).truth_T_estimate, transform, kTight));
}

TEST(Alignment, PositionYawLeavesATiltInPlace) {
  const double tilt = 0.02;
  const Trajectory estimate = test::helix(200);
  const MatchedTrajectories matched =
      match(estimate, test::moved({so3::exp({tilt, 0, 0}), {0, 0, 0}}, estimate));
  const SE3 found = align(matched, Alignment::kPositionYaw).truth_T_estimate;
  EXPECT_TRUE(test::agree(found.R.col(2), Eigen::Vector3d(0, 0, 1), 1e-15));
  EXPECT_NEAR(absolute_error(matched, Alignment::kPositionYaw).attitude_deg.rmse,
              tilt * 180 / std::numbers::pi, 2e-3);
}

TEST(Alignment, FirstLevelTakesPositionAndHeadingOfTheFirstPoseAlone) {
  const SE3 transform{so3::exp({0, 0, 0.7}), {5, -2, 1}};
  Trajectory estimate = test::helix(50);
  const Trajectory truth = test::moved(transform, estimate);
  for (std::size_t i = 1; i < estimate.size(); ++i)
    estimate[i].pose.p.x() += 1;  // not used by the alignment
  const Eigen::Matrix3d level = estimate.front().pose.R;
  EXPECT_TRUE(same(align(match(estimate, truth), Alignment::kFirstLevel).truth_T_estimate,
                   transform, kTight));
  // An initial tilt remains, in the body's axes and in the world's.
  estimate.front().pose.R = so3::exp({0.02, 0, 0}) * level;
  const SE3 found = align(match(estimate, truth), Alignment::kFirstLevel).truth_T_estimate;
  EXPECT_TRUE(test::agree(found.R.col(2), Eigen::Vector3d(0, 0, 1), 1e-15));
  EXPECT_NEAR(so3::log(found.R * transform.R.transpose()).norm(), 0, 2e-4);
}

TEST(Alignment, SimilarityRecoversTheScale) {
  Trajectory truth = test::moved(test::some_transform(), test::helix(200));
  Trajectory estimate = test::helix(200);
  for (StampedPose& row : estimate) row.pose.p /= 1.07;
  const MatchedTrajectories matched = match(estimate, truth);
  const WorldAlignment found = align(matched, Alignment::kSimilarity);
  EXPECT_NEAR(found.scale, 1.07, kTight);
  EXPECT_TRUE(same(found.truth_T_estimate, test::some_transform(), kTight));
  EXPECT_LT(absolute_error(matched, Alignment::kSimilarity).position_m.max, 1e-9);
  EXPECT_GT(absolute_error(matched, Alignment::kRigid).position_m.rmse, 3);
}

TEST(Alignment, RigidMinimisesThePositionError) {
  test::Random random(31);
  Trajectory estimate = test::helix(100);
  for (StampedPose& row : estimate) row.pose.p += 3 * random.normal_vector(3);
  const MatchedTrajectories matched = match(estimate, test::helix(100));
  const auto cost = [&](const Vector6d& xi) {
    WorldAlignment moved = align(matched, Alignment::kRigid);
    moved.truth_T_estimate = se3::exp(xi) * moved.truth_T_estimate;
    double sum = 0;
    for (const StampedError& e : pose_errors(matched, moved)) sum += e.position.squaredNorm();
    return Eigen::VectorXd::Constant(1, sum);
  };
  const Vector6d zero = Vector6d::Zero();
  EXPECT_TRUE(test::agree(test::numeric_derivative(cost, zero), Eigen::MatrixXd::Zero(1, 6), 1e-6,
                          cost(zero)[0]));
}

TEST(Alignment, AMirrorImageIsNotAlignedByAReflection) {
  Trajectory mirrored = test::helix(100);
  for (StampedPose& row : mirrored) row.pose.p.z() = -row.pose.p.z();
  const SE3 found = align(match(mirrored, test::helix(100)), Alignment::kRigid).truth_T_estimate;
  EXPECT_NEAR((found.R.col(0).cross(found.R.col(1))).dot(found.R.col(2)), 1, 1e-12);
}

TEST(Alignment, OnAStraightLineTheAttitudesDecideTheTurnAboutIt) {
  const SE3 transform = test::some_transform();
  const Trajectory estimate =
      test::moved({so3::exp({0.4, 0.5, -0.6}), {7, 8, 9}}, test::straight(50, 1.0));
  const MatchedTrajectories matched = match(estimate, test::moved(transform, estimate));
  for (const Alignment kind : {Alignment::kRigid, Alignment::kSimilarity}) {
    const WorldAlignment found = align(matched, kind);
    EXPECT_EQ(found.rank, 1);
    EXPECT_NEAR(found.scale, 1, kTight);
    EXPECT_TRUE(same(found.truth_T_estimate, transform, kTight));
  }
}

TEST(Alignment, OfAStaticBodyTheAttitudesDecideTheRotation) {
  const SE3 transform = test::some_transform();
  Trajectory estimate = test::helix(50);
  for (StampedPose& row : estimate) row.pose.p = Eigen::Vector3d(5, 6, 7);
  const MatchedTrajectories matched = match(estimate, test::moved(transform, estimate));
  for (const Alignment kind : {Alignment::kRigid, Alignment::kSimilarity}) {
    const WorldAlignment found = align(matched, kind);
    EXPECT_EQ(found.rank, 0);
    EXPECT_EQ(found.scale, 1);
    EXPECT_TRUE(same(found.truth_T_estimate, transform, kTight));
  }
  const WorldAlignment yaw =
      align(match(estimate, test::moved({so3::exp({0, 0, 1}), {1, 2, 3}}, estimate)),
            Alignment::kPositionYaw);
  EXPECT_TRUE(same(yaw.truth_T_estimate, {so3::exp({0, 0, 1}), {1, 2, 3}}, kTight));
}

TEST(Alignment, NoneComparesAsIs) {
  const SE3 transform{Eigen::Matrix3d::Identity(), {3, 4, 0}};
  const Trajectory estimate = test::helix(50);
  const AbsoluteError error =
      absolute_error(match(estimate, test::moved(transform, estimate)), Alignment::kNone);
  EXPECT_NEAR(error.position_m.rmse, 5, 1e-12);
  EXPECT_NEAR(error.position_m.max, 5, 1e-12);
}

TEST(AbsoluteError, StatisticsAreThoseOfTheMagnitudes) {
  const Statistics odd = statistics({5, 1, 3});
  EXPECT_DOUBLE_EQ(odd.mean, 3);
  EXPECT_DOUBLE_EQ(odd.median, 3);
  EXPECT_DOUBLE_EQ(odd.max, 5);
  EXPECT_DOUBLE_EQ(odd.rmse, std::sqrt(35. / 3));
  EXPECT_DOUBLE_EQ(statistics({8, 1, 3, 4}).median, 3.5);
  EXPECT_EQ(statistics({}).count, 0U);
  EXPECT_TRUE(std::isnan(statistics({}).rmse));
}

TEST(AbsoluteError, ErrorsAreTruthMinusEstimateInTheTruthsWorld) {
  const Trajectory truth = test::helix(20);
  Trajectory estimate = truth;
  const Eigen::Vector3d theta(0.01, -0.02, 0.03);
  const Eigen::Vector3d offset(1, 2, 3);
  for (StampedPose& row : estimate) {
    row.pose = {so3::exp(-theta) * row.pose.R, row.pose.p - offset};
  }
  for (const StampedError& e : pose_errors(match(estimate, truth), {})) {
    EXPECT_TRUE(test::agree(e.attitude, theta, 1e-13));
    EXPECT_TRUE(test::agree(e.position, offset, 1e-13));
  }
}

}  // namespace
}  // namespace chasles
