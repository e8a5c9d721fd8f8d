#include <chasles/eval/alignment.hpp>
#include <chasles/viewers/placement.hpp>

namespace chasles {

Trajectory finite_poses(const Run& run) {
  Trajectory poses;
  for (const RunState& s : run.states) {
    if (!s.world_T_imu.p.allFinite() || !s.world_T_imu.R.allFinite()) continue;
    poses.push_back({.time = s.time, .pose = s.world_T_imu});
  }
  return poses;
}

SE3 truth_T_world(const Run& run) {
  const Alignment fit = is_level(run) ? Alignment::kPositionYaw : Alignment::kRigid;
  return align(associate(finite_poses(run), run.truth, run.pairing), fit).truth_T_estimate;
}

}  // namespace chasles
