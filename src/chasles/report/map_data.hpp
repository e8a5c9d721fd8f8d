#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include <chasles/run_folder/run.hpp>

namespace chasles {

/// `map` of a run with a prior map in the page's data: {sessions: [{name, begin, seconds,
/// cameras}], marks}. `begin`: the first time on the recording's clock [s]. The marks are columns
/// (encode.hpp) of the map's landmarks: id, x, y, z and cxx … czz in the run's world, relative to
/// its origin [m, m^2], session, own (SketchPoint::own), observations, views, and returned: 1 for
/// those that the run has recognised.
nlohmann::ordered_json map_json(const Run& run, const Eigen::Vector3d& origin);

}  // namespace chasles
