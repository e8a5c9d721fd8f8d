#include <chasles/filter/charts/chart_detail.hpp>

namespace chasles {
namespace {
namespace left_se3 {

using namespace chart_detail;

// The velocity error is that of the body velocity R^T v (Kleinert & Stilla, eq. 31).
void retract(State& x, const ErrorRef& xi) {
  const Eigen::Vector3d theta = xi.head<3>();
  SE3& T = x.world_T_imu;
  T.p += T.R * (so3::left_jacobian(theta) * xi.segment<3>(3));
  if (x.v_world) {
    const Eigen::Vector3d v_imu = T.R.transpose() * *x.v_world + xi.segment<3>(6);
    x.v_world = T.R * (so3::exp(theta) * v_imu);
  }
  T.R = T.R * so3::exp(theta);
  add_additive(x, xi);
  add_landmarks(x, xi);
}

Eigen::VectorXd local(const State& x, const State& y) {
  Eigen::VectorXd xi = differences(x, y);
  xi.head<6>() = se3::log(x.world_T_imu.inverse() * y.world_T_imu);
  if (x.v_world) {
    xi.segment<3>(6) =
        y.world_T_imu.R.transpose() * *y.v_world - x.world_T_imu.R.transpose() * *x.v_world;
  }
  return xi;
}

MotionBlock motion_block(const State& x) {
  const Eigen::Matrix3d Rt = x.world_T_imu.R.transpose();
  MotionBlock T = MotionBlock::Zero();
  T.block<3, 3>(0, 0) = Rt;
  T.block<3, 3>(3, 3) = Rt;
  T.block<3, 3>(6, 6) = Rt;
  if (x.v_world) T.block<3, 3>(6, 0) = Rt * hat(*x.v_world);
  return T;
}

}  // namespace left_se3
}  // namespace

const ErrorChart kLeftSe3Chart{
    .name = "left-se3",
    .summary = "pose error a twist in the body frame, X exp(xi); body velocity; landmarks additive",
    .retract = left_se3::retract,
    .local = left_se3::local,
    .motion_block = left_se3::motion_block,
    .landmark_block = nullptr,
};

}  // namespace chasles
