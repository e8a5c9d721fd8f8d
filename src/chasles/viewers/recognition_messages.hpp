#pragma once

#include <functional>

#include <nlohmann/json_fwd.hpp>

#include <chasles/run_folder/run.hpp>
#include <chasles/viewers/channels.hpp>

namespace chasles {

/// foxglove.FrameTransforms: the frame `world` in the frame `map` of a prior map; null where that
/// is not finite.
nlohmann::json map_frame_message(Time time, const SE3& map_T_world);

/// foxglove.PointCloud of the run's prior map, which it has, in the frame `map`: as /map, coloured
/// by session, with `session` and `returned`.
nlohmann::json prior_map_message(const Run& run, Time time);

/// Calls `take` with a foxglove.SceneUpdate for each loop closure of the summary: a sphere where
/// the run was then, and a text with the landmarks that returned, the jump and chi2. Those without
/// a finite state are left out. Throws InputError if the list is malformed.
void closure_messages(const nlohmann::json& summary, const Run& run,
                      const std::function<void(Time, const nlohmann::json&)>& take);

/// Adds /tf_map at each state of Run::in_map.
void add_map_frame(const Run& run, Channels& out);

}  // namespace chasles
