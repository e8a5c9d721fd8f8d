#pragma once

#include <Eigen/Geometry>

#include <chasles/camera/camera.hpp>
#include <chasles/sim/render_world.hpp>

// Shared by the tests of the renderer.
namespace chasles::test {

/// A camera at the IMU's position. Its optical axis is the IMU's x axis, right is -y, down is -z.
inline Camera forward_camera(int width, int height, double focal_length) {
  Eigen::Matrix3d imu_R_cam;
  imu_R_cam << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {.width = width,
          .height = height,
          .fx = focal_length,
          .fy = focal_length * 1.01,
          .cx = width / 2.0 - 0.3,
          .cy = height / 2.0 + 0.2,
          .cam_T_imu = SE3{imu_R_cam, Eigen::Vector3d::Zero()}.inverse()};
}

inline SE3 looking(double yaw, double pitch, double roll, const Eigen::Vector3d& p) {
  using Eigen::Vector3d;
  return {so3::exp(yaw * Vector3d::UnitZ()) * so3::exp(pitch * Vector3d::UnitY()) *
              so3::exp(roll * Vector3d::UnitX()),
          p};
}

/// A room of 6 x 6 x 3 m about the origin, with chessboards on all surfaces.
inline RenderWorld chess_room(const std::vector<Box>& furniture = {}) {
  RenderWorld world = furnished({.rooms = {{{-3, -3}, {3, 3}}}}, -1.5, 1.5, furniture);
  for (Surface& surface : world.surfaces) surface.material = Material::kChessboard;
  return world;
}

}  // namespace chasles::test
