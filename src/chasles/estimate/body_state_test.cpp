#include <gtest/gtest.h>

#include <chasles/estimate/body_state.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using Vector15d = Eigen::Matrix<double, 15, 1>;
using Vector12d = Eigen::Matrix<double, 12, 1>;

ImuMotion some_motion() {
  ImuMotion motion{.world_T_imu = {so3::exp({0.3, -0.5, 1.1}), {1, 2, 3}},
                   .v_world = {0.7, -1.1, 0.4},
                   .angular_rate_imu = {0.2, -0.6, 0.9}};
  Eigen::Matrix<double, 15, 15> root;
  for (int i = 0; i < 15; ++i) {
    for (int j = 0; j < 15; ++j)
      root(i, j) = 0.01 * ((7 * i + 3 * j) % 11 - 5) + (i == j ? 0.1 : 0);
  }
  motion.covariance = root * root.transpose();
  motion.rate_variance = 0.04;
  return motion;
}

const SE3 kBodyTImu{so3::exp({-0.4, 0.2, 0.8}), {0.5, -0.25, 0.125}};

/// The motion whose errors against `motion` are `d`, with a white noise of the rate.
ImuMotion disturbed(const ImuMotion& motion, const Vector15d& d, const Eigen::Vector3d& noise) {
  ImuMotion result = motion;
  result.world_T_imu.R = so3::exp(d.segment<3>(0)) * motion.world_T_imu.R;
  result.world_T_imu.p += d.segment<3>(3);
  result.v_world += d.segment<3>(6);
  result.angular_rate_imu -= d.segment<3>(12) + noise;  // measured less a larger bias
  return result;
}

/// Position and rotation errors in world axes, and errors of the twist, of b against a.
Vector12d body_difference(const BodyState& a, const BodyState& b) {
  Vector12d d;
  d << b.world_T_body.p - a.world_T_body.p,
      so3::log(b.world_T_body.R * a.world_T_body.R.transpose()), b.linear - a.linear,
      b.angular - a.angular;
  return d;
}

TEST(BodyState, AnImuThatIsTheBodyHasItsPoseAndItsVelocityInItsAxes) {
  const ImuMotion motion = some_motion();
  const BodyState body = body_state(motion, SE3{});
  EXPECT_EQ(body.world_T_body.p, motion.world_T_imu.p);
  EXPECT_TRUE(body.linear.isApprox(motion.world_T_imu.R.transpose() * motion.v_world));
  EXPECT_EQ(body.angular, motion.angular_rate_imu);
  EXPECT_TRUE(
      body.pose_covariance.isApprox(position_first(motion.covariance.topLeftCorner<6, 6>())));
  EXPECT_EQ(body.pose_covariance(0, 5), motion.covariance(3, 2));  // x, rotation about z
}

// The velocity of the origin is the derivative of its position.
TEST(BodyState, MovesAsARigidBody) {
  const ImuMotion motion = some_motion();
  const double dt = 1e-6;
  ImuMotion later = motion;
  later.world_T_imu.R = motion.world_T_imu.R * so3::exp(motion.angular_rate_imu * dt);
  later.world_T_imu.p += motion.v_world * dt;
  const BodyState now = body_state(motion, kBodyTImu), then = body_state(later, kBodyTImu);
  const Eigen::Matrix3d body_R_world = now.world_T_body.R.transpose();
  const Eigen::Vector3d linear = body_R_world * (then.world_T_body.p - now.world_T_body.p) / dt;
  const Eigen::Vector3d angular = so3::log(body_R_world * then.world_T_body.R) / dt;
  EXPECT_TRUE(now.linear.isApprox(linear, 1e-5)) << now.linear << " " << linear;
  EXPECT_TRUE(now.angular.isApprox(angular, 1e-5));
  EXPECT_TRUE((now.world_T_body * kBodyTImu).p.isApprox(motion.world_T_imu.p));
}

TEST(BodyState, CovariancesFollowFromNumericDerivatives) {
  const ImuMotion motion = some_motion();
  const BodyState body = body_state(motion, kBodyTImu);
  Eigen::Matrix<double, 12, 18> J;
  const double step = 1e-6;
  for (int i = 0; i < 18; ++i) {
    const auto moved = [&](double by) {
      Vector15d d = Vector15d::Zero();
      Eigen::Vector3d noise = Eigen::Vector3d::Zero();
      (i < 15 ? d[i] : noise[i - 15]) = by;
      return body_state(disturbed(motion, d, noise), kBodyTImu);
    };
    J.col(i) =
        (body_difference(body, moved(step)) - body_difference(body, moved(-step))) / (2 * step);
  }
  Eigen::Matrix<double, 18, 18> P = Eigen::Matrix<double, 18, 18>::Zero();
  P.topLeftCorner<15, 15>() = motion.covariance;
  P.bottomRightCorner<3, 3>() = motion.rate_variance * Eigen::Matrix3d::Identity();
  const Eigen::Matrix<double, 12, 12> all = J * P * J.transpose();
  EXPECT_TRUE(body.pose_covariance.isApprox(all.topLeftCorner<6, 6>(), 1e-6));
  EXPECT_TRUE(body.twist_covariance.isApprox(all.bottomRightCorner<6, 6>(), 1e-6));
}

TEST(BodyState, PositionFirstIsItsOwnInverse) {
  const Matrix6d P = some_motion().covariance.topLeftCorner<6, 6>();
  EXPECT_EQ(position_first(position_first(P)), P);
  EXPECT_EQ(position_first(P)(0, 0), P(3, 3));
  EXPECT_EQ(position_first(P)(4, 2), P(1, 5));
}

}  // namespace
}  // namespace chasles
