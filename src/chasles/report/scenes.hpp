#pragma once

#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/report/against_truth.hpp>
#include <chasles/report/report.hpp>

namespace chasles {

/// What web/src/scenes.ts reads: a scene for each true way that several runs share, or that has a
/// floor plan: [{name, origin, truth: {x, y, z}, plan: {wall: {x, y}, furniture: {x, y}}, runs:
/// [{run, t, x, y, z, ex, ey, ez, nees, mean_nees: {position, attitude, pose}}]}].
///
/// All in the truth's world, relative to the origin (its first position); lines of the plan are
/// separated by NaN. `run` is an index into the runs; t their times since the truth's first [s]; x,
/// y, z their positions, placed on the truth by the best fit; ex, ey, ez those less the true ones
/// [m]; nees that of the pose. The fit is of position and yaw where gravity tells what is vertical
/// (is_level()), else rigid. Runs without a truth, or whose truth cannot be compared, are in no
/// scene.
///
/// `errors[i]` is against_truth() of runs[i].
nlohmann::ordered_json scenes_json(const std::vector<ReportRun>& runs,
                                   const std::vector<AgainstTruth>& errors);

}  // namespace chasles
