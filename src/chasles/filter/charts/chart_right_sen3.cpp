#include <chasles/filter/charts/chart_detail.hpp>

namespace chasles {
namespace {
namespace right_sen3 {

using namespace chart_detail;

// Pose, velocity and landmarks move together as one element of SE_{2+N}(3): the rotation of the
// exponential moves them all about the world's origin (docs/derivations.md, D12).
void retract(State& x, const ErrorRef& xi) {
  const Eigen::Vector3d theta = xi.head<3>();
  const Eigen::Matrix3d R = so3::exp(theta);
  const Eigen::Matrix3d J = so3::left_jacobian(theta);
  const auto move = [&](Eigen::Vector3d& p, int row) { p = R * p + J * xi.segment<3>(row); };
  x.world_T_imu.R = R * x.world_T_imu.R;
  move(x.world_T_imu.p, 3);
  if (x.v_world) move(*x.v_world, 6);
  add_additive(x, xi);
  for (Landmark& landmark : x.landmarks) {
    if (landmark.anchor) {
      landmark.inverse_depth += xi.segment<3>(landmark.row);
    } else {
      move(landmark.p_world, landmark.row);
    }
  }
}

Eigen::VectorXd local(const State& x, const State& y) {
  Eigen::VectorXd xi = differences(x, y);
  const Eigen::Matrix3d R = y.world_T_imu.R * x.world_T_imu.R.transpose();
  const Eigen::Vector3d theta = so3::log(R);
  const Eigen::Matrix3d Ji = so3::left_jacobian_inverse(theta);
  const auto between = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to, int row) {
    xi.segment<3>(row) = Ji * (to - R * from);
  };
  xi.head<3>() = theta;
  between(x.world_T_imu.p, y.world_T_imu.p, 3);
  if (x.v_world) between(*x.v_world, *y.v_world, 6);
  for (std::size_t i = 0; i < x.landmarks.size(); ++i) {
    if (x.landmarks[i].anchor) continue;
    between(x.landmarks[i].p_world, y.landmarks[i].p_world, x.landmarks[i].row);
  }
  return xi;
}

MotionBlock motion_block(const State& x) {
  MotionBlock T = MotionBlock::Identity();
  T.block<3, 3>(3, 0) = hat(x.world_T_imu.p);
  if (x.v_world) T.block<3, 3>(6, 0) = hat(*x.v_world);
  return T;
}

Eigen::Matrix3d landmark_block(const Eigen::Vector3d& p_world) { return hat(p_world); }

}  // namespace right_sen3
}  // namespace

const ErrorChart kRightSen3Chart{
    .name = "right-sen3",
    .summary = "pose, velocity and landmarks one group element, perturbed in the world frame",
    .retract = right_sen3::retract,
    .local = right_sen3::local,
    .motion_block = right_sen3::motion_block,
    .landmark_block = right_sen3::landmark_block,
};

}  // namespace chasles
