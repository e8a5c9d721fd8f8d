#pragma once

#include <string>

#include <chasles/report/report.hpp>
#include <chasles/viewers/run_path.hpp>

namespace chasles {

/// Two tables of Project Aria's machine perception services, as projectaria-tools reads them
/// (docs/exports.md).
struct MpsFiles {
  std::string trajectory;  ///< closed_loop_trajectory.csv
  std::string points;      ///< semidense_points.csv.gz
};

/// The path as a closed loop trajectory, whose device is the IMU, and the map as its points, in the
/// world of the run. The linear velocity is that of the states, else from the path; the angular
/// velocity is from the path: over the two neighbours of a pose. The quality is 1, 0.5 or 0 for a
/// health of ok, degraded or lost. The standard deviations of a point are along the ray from the
/// IMU where the point was first seen. Rows that are not finite are left out. Throws InputError
/// for a run without two poses of that path, and for one whose world is not level.
MpsFiles run_mps(const ReportRun& run, RunPath path);

}  // namespace chasles
