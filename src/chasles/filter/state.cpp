#include <chasles/filter/pixel_projection.hpp>
#include <chasles/filter/state.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

// imu_R_cam (a, b, 1) of the inverse depth (a, b, w).
Eigen::Vector3d ray_in_imu(const Landmark& landmark) {
  const Eigen::Vector3d& a = landmark.inverse_depth;
  return landmark.cam_T_imu.R.transpose() * Eigen::Vector3d(a.x(), a.y(), 1);
}

HomogeneousPoint anchored(const SE3& world_T_imu, const Landmark& landmark) {
  const double w = landmark.inverse_depth.z();
  const Eigen::Vector3d p_imu = ray_in_imu(landmark) + w * landmark.cam_T_imu.inverse().p;
  return {.p_world = world_T_imu.R * p_imu + w * world_T_imu.p, .w = w};
}

}  // namespace

HomogeneousPoint homogeneous(const Clone& anchor, const Landmark& landmark) {
  return anchored(anchor.world_T_imu, landmark);
}

HomogeneousPoint State::homogeneous(const Landmark& landmark) const {
  if (!landmark.anchor) return {.p_world = landmark.p_world, .w = 1};
  return anchored(clone(*landmark.anchor).world_T_imu, landmark);
}

Eigen::Matrix<double, 3, 9> homogeneous_derivative(const Clone& anchor, const Landmark& landmark) {
  const SE3& world_T_imu = anchor.world_T_imu;
  const double w = landmark.inverse_depth.z();
  const HomogeneousPoint point = anchored(world_T_imu, landmark);
  Eigen::Matrix<double, 3, 9> d;
  d << -hat(point.p_world - w * world_T_imu.p), w * Eigen::Matrix3d::Identity(),
      (world_T_imu.R * landmark.cam_T_imu.R.transpose()).leftCols<2>(),
      world_T_imu * landmark.cam_T_imu.inverse().p;
  return d;
}

Eigen::Matrix<double, 3, 6> homogeneous_derivative_by_camera(const Clone& anchor,
                                                             const Landmark& landmark) {
  Eigen::Matrix<double, 3, 6> d;
  d << -hat(ray_in_imu(landmark)), landmark.inverse_depth.z() * Eigen::Matrix3d::Identity();
  d = (anchor.world_T_imu.R * d).eval();
  return by_axes_of_line(d, landmark.imu_T_line);
}

Eigen::Matrix<double, 3, 9> anchored_derivative(const Clone& anchor, const Landmark& landmark) {
  const HomogeneousPoint point = anchored(anchor.world_T_imu, landmark);
  Eigen::Matrix<double, 3, 9> d = homogeneous_derivative(anchor, landmark);
  d.rightCols<1>() -= point.p_world / point.w;
  return d / point.w;
}

Eigen::Matrix<double, 3, 6> anchored_derivative_by_camera(const Clone& anchor,
                                                          const Landmark& landmark) {
  return homogeneous_derivative_by_camera(anchor, landmark) / landmark.inverse_depth.z();
}

}  // namespace chasles
