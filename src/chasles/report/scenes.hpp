#pragma once

#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/report/report.hpp>

namespace chasles {

/// What web/js/overview.js reads: a scene for each true way that several runs share, or that has a
/// floor plan: [{name, origin, truth: {x, y, z}, plan: {wall: {x, y}, furniture: {x, y}}, runs:
/// [{run, level, t, x, y, z, ex, ey, ez, nees, mean_nees: {position, attitude, pose}}]}].
///
/// All in the truth's world, relative to the origin (its first position); lines of the plan are
/// separated by NaN. `run` is an index into the runs; t their times since the truth's first [s]; x,
/// y, z their positions, placed on the truth by the best fit; ex, ey, ez those less the true ones
/// [m]. `level`: the run has an IMU, so that gravity tells what is vertical. The fit is then of
/// position and yaw, and for the NEES position and heading of the first poses are brought together;
/// else it is rigid, and the whole first poses are. (To bring them together with an IMU too, as
/// nees() does, would turn the error of the first tilt, of which the filter is not certain, into
/// one of all later poses, whose tilt it knows.) Runs without a truth, or whose truth cannot be
/// compared, are in no scene.
nlohmann::ordered_json scenes_json(const std::vector<ReportRun>& runs);

}  // namespace chasles
