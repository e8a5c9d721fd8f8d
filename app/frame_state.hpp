#pragma once

#include <string>
#include <vector>

#include <chasles/data/run.hpp>
#include <chasles/slam/velocity_slam.hpp>

namespace chasles::app {

/// Run::stage_names of a filter.
inline std::vector<std::string> filter_stage_names() {
  return {"propagation", "update", "landmarks"};
}

/// What a filter of any rig says of a frame, as a line of the run: an Estimate or an
/// InertialEstimate, of which the pose and the motion's own states are still to be filled in.
template <typename E>
RunState frame_state(const E& e, double milliseconds) {
  RunState state;
  state.time = e.time;
  state.nis = e.nis;
  state.nis_dof = e.nis_dof;
  state.observations = e.observations;
  state.used = e.used;
  state.rejected = e.rejected;
  state.added = e.added;
  state.in_state = e.in_state;
  state.landmarks = e.landmarks;
  state.health = name(e.health);
  state.milliseconds = milliseconds;
  state.stages = {1e3 * e.seconds.propagation, 1e3 * e.seconds.update, 1e3 * e.seconds.landmarks};
  return state;
}

}  // namespace chasles::app
