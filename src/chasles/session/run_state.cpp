#include <algorithm>
#include <cmath>

#include <chasles/session/calibration_report.hpp>
#include <chasles/session/run_state.hpp>

namespace chasles {

RunState run_state(const Estimate& e, std::span<const Camera> cameras) {
  RunState state;
  state.time = e.time;
  state.world_T_imu = e.world_T_imu;
  state.pose_covariance = e.pose_covariance();
  if (e.v_world) state.extra = {e.v_world->begin(), e.v_world->end()};
  state.extra.insert(state.extra.end(), e.additive.begin(), e.additive.end());
  for (Eigen::Index row = 6; row < e.covariance.rows(); ++row) {
    state.extra_sigma.push_back(std::sqrt(std::max(e.covariance(row, row), 0.0)));
  }
  if (e.calibration) append_calibration(*e.calibration, cameras, state);
  state.nis = e.nis;
  state.nis_dof = e.nis_dof;
  state.observations = e.observations;
  state.used = e.used;
  state.rejected = e.rejected;
  state.added = e.added;
  state.in_state = e.in_state;
  state.landmarks = e.landmarks;
  state.health = name(e.health);
  return state;
}

}  // namespace chasles
