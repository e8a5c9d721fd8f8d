#pragma once

#include <span>
#include <string>

#include <chasles/report/report.hpp>
#include <chasles/viewers/run_path.hpp>

namespace chasles {

/// camera_trajectory.csv as the SLAM pipeline of UMI reads it (docs/exports.md): one row a frame of
/// the recording, with the pose world_T_cam0 (camera axes, z forward) and the seconds since the
/// first frame. A frame without a pose, or where the run was lost, is `is_lost`, with zeros. All
/// others are keyframes: the pipeline looks for its tag in keyframes alone. `stamps`: of all
/// frames. Throws InputError as poses_at_frames() and imu_T_camera().
std::string run_umi(const ReportRun& run, RunPath path, std::span<const Time> stamps);

}  // namespace chasles
