#include <chasles/codec/numbers.hpp>
#include <chasles/viewers/colmap_rig.hpp>

namespace chasles {

std::array<double, 7> colmap_pose(const SE3& pose) {
  const Eigen::Vector4d q = unit_quaternion(pose.R);
  return {q[3], q[0], q[1], q[2], pose.p.x(), pose.p.y(), pose.p.z()};
}

SE3 world_T_camera(const ColmapModel& model, const ColmapFrame& frame, std::size_t camera) {
  return frame.world_T_imu * model.cameras[camera].cam_T_imu.inverse();
}

SE3 camera_T_first(const ColmapModel& model, std::size_t camera) {
  return model.cameras[camera].cam_T_imu * model.cameras.front().cam_T_imu.inverse();
}

}  // namespace chasles
