#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <chasles/run_folder/run.hpp>

namespace chasles {

/// Which poses of a run: those of states.csv, or those of smoothed.csv.
enum class RunPath { kStates, kSmoothed };

bool is_finite(const SE3& pose);

/// The poses of that path that are finite, at least one. Throws InputError for a run without one.
std::vector<SmoothedPose> path_poses(const Run& run, RunPath path);

/// Appends `t x y z qx qy qz qw` [s, m], without the end of the line.
void append_tum(Time time, const SE3& pose, std::string& text);

/// Three columns of states.csv, NAME_x, NAME_y and NAME_z, as their place in RunState::extra; none
/// if the run has no such columns.
std::optional<std::size_t> extra_vector_at(const Run& run, std::string_view name);

/// imu_T_camN as summary.json has it: the calibration of the recording, not what the run has
/// corrected. Throws InputError for a summary without that camera.
SE3 imu_T_camera(std::string_view summary, std::size_t camera);

/// The place of a camera of the run among those of its recording: with --cameras another one.
std::size_t recorded_camera(std::string_view summary, std::size_t camera);

}  // namespace chasles
