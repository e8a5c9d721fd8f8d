#include <Eigen/Geometry>

#include <chasles/estimate/body_state.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using BodyJacobian = Eigen::Matrix<double, 6, 15>;

// Blocks of an Estimate's errors.
constexpr int kTheta = 0, kPosition = 3, kVelocity = 6, kRateBias = 12;

// d [position; rotation] of the body / d errors. p_body = p + R r: a rotation moves the body's
// origin, which lies at r.
BodyJacobian pose_jacobian(const ImuMotion& motion, const Eigen::Vector3d& r_imu) {
  BodyJacobian J = BodyJacobian::Zero();
  J.block<3, 3>(0, kPosition).setIdentity();
  J.block<3, 3>(0, kTheta) = -hat(motion.world_T_imu.R * r_imu);
  J.block<3, 3>(3, kTheta).setIdentity();
  return J;
}

// d [linear; angular] / d errors, with linear = body_R_imu (R^T v + omega x r). An error of the
// bias is the opposite one of omega.
BodyJacobian twist_jacobian(const ImuMotion& motion, const Eigen::Matrix3d& body_R_imu,
                            const Eigen::Vector3d& r_imu) {
  const Eigen::Matrix3d body_R_world = body_R_imu * motion.world_T_imu.R.transpose();
  BodyJacobian J = BodyJacobian::Zero();
  J.block<3, 3>(0, kTheta) = body_R_world * hat(motion.v_world);
  J.block<3, 3>(0, kVelocity) = body_R_world;
  J.block<3, 3>(0, kRateBias) = body_R_imu * hat(r_imu);
  J.block<3, 3>(3, kRateBias) = -body_R_imu;
  return J;
}

}  // namespace

Matrix6d position_first(const Matrix6d& rotation_first) {
  Matrix6d result;
  result << rotation_first.bottomRightCorner<3, 3>(), rotation_first.bottomLeftCorner<3, 3>(),
      rotation_first.topRightCorner<3, 3>(), rotation_first.topLeftCorner<3, 3>();
  return result;
}

BodyState body_state(const ImuMotion& motion, const SE3& body_T_imu) {
  const Eigen::Vector3d r_imu = body_T_imu.inverse().p;
  const Eigen::Matrix3d& body_R_imu = body_T_imu.R;
  const Eigen::Matrix<double, 15, 15> P = motion.covariance.topLeftCorner<15, 15>();
  const BodyJacobian of_pose = pose_jacobian(motion, r_imu);
  const BodyJacobian of_twist = twist_jacobian(motion, body_R_imu, r_imu);
  // White noise of the rate acts as an error of its bias does.
  const Eigen::Matrix<double, 6, 3> of_rate = of_twist.block<6, 3>(0, kRateBias);
  BodyState body;
  body.world_T_body = motion.world_T_imu * body_T_imu.inverse();
  body.pose_covariance = of_pose * P * of_pose.transpose();
  body.linear = body_R_imu * (motion.world_T_imu.R.transpose() * motion.v_world +
                              motion.angular_rate_imu.cross(r_imu));
  body.angular = body_R_imu * motion.angular_rate_imu;
  body.twist_covariance =
      of_twist * P * of_twist.transpose() + motion.rate_variance * of_rate * of_rate.transpose();
  return body;
}

}  // namespace chasles
