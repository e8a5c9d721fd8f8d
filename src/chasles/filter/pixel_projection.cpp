#include <algorithm>

#include <chasles/filter/pixel_projection.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {

std::optional<Seen> see(const Camera& camera, const SE3& world_T_imu, const HomogeneousPoint& point,
                        const Eigen::Vector2d& pixel, double least_depth) {
  return see(camera, camera.cam_T_imu, world_T_imu, point, pixel, least_depth);
}

std::optional<Seen> see(const Camera& camera, const SE3& cam_T_imu, const SE3& world_T_imu,
                        const HomogeneousPoint& point, const Eigen::Vector2d& pixel,
                        double least_depth) {
  constexpr double kLeastW =
      0.01;  // limits the angle from the axis for points at or beyond infinity
  const Eigen::Matrix3d cam_R_world = cam_T_imu.R * world_T_imu.R.transpose();
  const Eigen::Vector3d from_imu = point.p_world - point.w * world_T_imu.p;
  const Eigen::Vector3d p_cam = cam_R_world * from_imu + point.w * cam_T_imu.p;
  const double least = least_depth * std::max(point.w, kLeastW);
  double scale = p_cam.z();
  if (!(scale > least)) {
    scale = p_cam.norm();
    if (!sees_beside(camera) || !(scale > least)) return std::nullopt;
  }
  const auto projection = project(camera, p_cam / scale);
  if (!projection) return std::nullopt;
  const Eigen::Matrix<double, 2, 3> d_p_cam = projection->d_point / scale;
  Seen seen;
  seen.residual = pixel - projection->pixel;
  seen.d_point = d_p_cam * cam_R_world;
  seen.d_w = d_p_cam * cam_T_imu.p - seen.d_point * world_T_imu.p;
  seen.d_pose << seen.d_point * hat(from_imu), -point.w * seen.d_point;
  return seen;
}

Eigen::Vector3d in_camera(const Camera& camera, const SE3& world_T_imu,
                          const HomogeneousPoint& point) {
  const Eigen::Vector3d p_imu =
      world_T_imu.R.transpose() * (point.p_world - point.w * world_T_imu.p);
  return camera.cam_T_imu.R * p_imu + point.w * camera.cam_T_imu.p;
}

Eigen::Matrix<double, 2, 6> derivative_by_camera(const Camera& camera, const SE3& world_T_imu,
                                                 const HomogeneousPoint& point,
                                                 const Eigen::Matrix<double, 2, 3>& d_point,
                                                 const SE3& imu_T_line) {
  const Eigen::Matrix<double, 2, 3> d_imu = d_point * world_T_imu.R;
  const Eigen::Vector3d p_imu =
      world_T_imu.R.transpose() * (point.p_world - point.w * world_T_imu.p);
  Eigen::Matrix<double, 2, 6> d;
  d << d_imu * hat(p_imu - point.w * camera.cam_T_imu.inverse().p), -point.w * d_imu;
  return by_axes_of_line(d, imu_T_line);
}

}  // namespace chasles
