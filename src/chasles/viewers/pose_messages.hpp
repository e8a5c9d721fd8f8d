#pragma once

#include <nlohmann/json_fwd.hpp>

#include <chasles/recording/georeference.hpp>
#include <chasles/run_folder/run.hpp>

// Messages of single states, as values for proto_bytes(). They are null where the state's pose is
// not finite.
namespace chasles {

/// foxglove.FrameTransforms: `imu` in `world`.
nlohmann::json tf_message(const RunState& state);
/// foxglove.PoseInFrame.
nlohmann::json pose_message(const RunState& state);
/// foxglove.Odometry: the pose with its covariance, position first.
nlohmann::json odometry_message(const RunState& state);
/// foxglove.LocationFix: the place on the Earth, with `truth_T_world` of the truth's world.
nlohmann::json location_message(const RunState& state, const SE3& truth_T_world,
                                const Georeference& georeference);

/// foxglove.PoseInFrame in `world`.
nlohmann::json pose_in_world(Time time, const SE3& pose);
/// foxglove.FrameTransforms: the cameras in `imu`, by `cameras` of the summary; null where that is
/// absent. Throws InputError if it is malformed.
nlohmann::json cameras_message(const nlohmann::json& summary, Time time);

}  // namespace chasles
