#include <chasles/filter/state.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {

Eigen::Matrix<double, 3, 9> anchored_derivative(const Clone& anchor, const Landmark& landmark) {
  const Eigen::Vector3d& a = landmark.inverse_depth;
  const Eigen::Vector3d p_cam = Eigen::Vector3d(a.x(), a.y(), 1) / a.z();
  const SE3 imu_T_cam = landmark.cam_T_imu.inverse();
  Eigen::Matrix3d d_inverse_depth;
  d_inverse_depth << Eigen::Vector3d::UnitX() / a.z(), Eigen::Vector3d::UnitY() / a.z(),
      -p_cam / a.z();
  Eigen::Matrix<double, 3, 9> d;
  d << -hat(anchor.world_T_imu.R * (imu_T_cam * p_cam)), Eigen::Matrix3d::Identity(),
      anchor.world_T_imu.R * imu_T_cam.R * d_inverse_depth;
  return d;
}

Eigen::Matrix<double, 3, 6> anchored_derivative_by_camera(const Clone& anchor,
                                                          const Landmark& landmark) {
  const Eigen::Vector3d& a = landmark.inverse_depth;
  const Eigen::Vector3d p_cam = Eigen::Vector3d(a.x(), a.y(), 1) / a.z();
  Eigen::Matrix<double, 3, 6> d;
  d << -hat(landmark.cam_T_imu.R.transpose() * p_cam), Eigen::Matrix3d::Identity();
  return anchor.world_T_imu.R * d;
}

}  // namespace chasles
