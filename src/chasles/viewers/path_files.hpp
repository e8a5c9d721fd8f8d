#pragma once

#include <string>

#include <chasles/report/report.hpp>
#include <chasles/viewers/run_path.hpp>

// Paths in the text formats of benchmarks (docs/exports.md). Poses that are not finite are left
// out. Each function throws InputError for a run without poses of that path.
namespace chasles {

/// world_T_imu as TUM's lines `t tx ty tz qx qy qz qw` [s, m]: as trajectory.tum of the run folder,
/// or trajectory_smoothed.tum.
std::string run_tum(const Run& run, RunPath path);

/// KITTI odometry's poses, and their times, which KITTI has in a file of its own.
struct KittiFiles {
  std::string poses;  ///< the rows of [R | p] of first_cam0_T_cam0, 12 numbers a line [m]
  std::string times;  ///< one a line [s], by the clock of the run
};

/// The path of camera 0 in the axes of its first pose. Throws InputError as imu_T_camera(), too.
KittiFiles run_kitti(const ReportRun& run, RunPath path);

/// world_T_imu as EuRoC's state_groundtruth_estimate0/data.csv: nanoseconds, position, quaternion
/// w x y z and, of the states of a run with an IMU, velocity (world axes) and the biases of
/// gyroscope and accelerometer (IMU axes).
std::string run_euroc(const Run& run, RunPath path);

}  // namespace chasles
