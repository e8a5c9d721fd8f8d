#pragma once

#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/report/against_truth.hpp>
#include <chasles/report/report.hpp>

namespace chasles {

/// The input of src/web/src/scenes.ts: one scene for each true trajectory that several runs share,
/// or that has a floor plan: [{name, origin, truth: {x, y, z}, plan: {wall: {x, y}, furniture: {x,
/// y}}, runs: [{run, t, x, y, z, ex, ey, ez, nees, mean_nees: {position, attitude, pose}}]}].
/// Runs without a truth share a scene if they have the same plan; their world is the plan's. The
/// origin is then the first position of the first of them, t are the times since the run's first
/// state, and truth, ex, ey, ez, nees and mean_nees are absent.
///
/// All is in the truth's world, relative to the origin (its first position). NaN separates lines of
/// the plan. `run` is an index into the runs; t their times since the truth's first [s]; x, y, z
/// their positions, aligned with the truth by the best fit; ex, ey, ez the same minus the true
/// positions [m]; nees that of the pose. The fit is of position and yaw if the run is_level(), else
/// rigid. Runs whose truth cannot be compared, or without truth and plan, are in no scene.
///
/// `errors[i]` is against_truth() of runs[i].
nlohmann::ordered_json scenes_json(const std::vector<ReportRun>& runs,
                                   const std::vector<AgainstTruth>& errors);

}  // namespace chasles
