#pragma once

#include <nlohmann/json_fwd.hpp>

#include <chasles/data/run.hpp>
#include <chasles/viewers/channels.hpp>

namespace chasles {

/// Adds /tf_map: the frame `world` in the frame `map` of a prior map, at each state of Run::in_map.
void add_map_frame(const Run& run, Channels& out);

/// Adds /map/prior, a foxglove.PointCloud of the run's prior map in the frame `map` at `time`: as
/// /map, coloured by session, with `session` and `returned`.
void add_prior_map(const Run& run, Time time, Channels& out);

/// Adds /closures, a foxglove.SceneUpdate at each loop closure of the summary: a sphere where the
/// run was then, and a text with the landmarks that returned, the jump and chi2. Throws InputError
/// if the list is malformed.
void add_closures(const nlohmann::json& summary, const Run& run, Channels& out);

}  // namespace chasles
