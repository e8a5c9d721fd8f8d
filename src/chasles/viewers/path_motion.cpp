#include <algorithm>

#include <chasles/lie/so3.hpp>
#include <chasles/viewers/path_motion.hpp>

namespace chasles {

PathMotion motion_at(const std::vector<SmoothedPose>& poses, std::size_t i) {
  const SmoothedPose& before = poses[i == 0 ? 0 : i - 1];
  const SmoothedPose& after = poses[std::min(i + 1, poses.size() - 1)];
  const double seconds = to_seconds(after.time - before.time);
  const Eigen::Matrix3d& R = poses[i].world_T_imu.R;
  return {.velocity = R.transpose() * (after.world_T_imu.p - before.world_T_imu.p) / seconds,
          .rate = so3::log(before.world_T_imu.R.transpose() * after.world_T_imu.R) / seconds};
}

}  // namespace chasles
