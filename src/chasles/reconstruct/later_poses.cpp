#include <chasles/reconstruct/later_poses.hpp>

namespace chasles {

LaterPoses::LaterPoses(const Run& run, RunPath path, double seconds)
    : delay_(from_seconds(seconds)) {
  for (const SmoothedPose& s : path_poses(run, path)) {
    path_.push_back({.time = s.time, .pose = s.world_T_imu});
  }
}

std::optional<SE3> LaterPoses::after(const SmoothedPose& pose) const {
  return pose_at(path_, pose.time + delay_);
}

}  // namespace chasles
