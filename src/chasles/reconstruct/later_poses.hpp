#pragma once

#include <optional>

#include <chasles/lie/trajectory.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/viewers/run_path.hpp>

namespace chasles {

/// The poses of a path some time after its states: a rolling shutter exposes the middle of an image
/// after the image's time.
class LaterPoses {
 public:
  /// Throws InputError as path_poses().
  LaterPoses(const Run& run, RunPath path, double seconds);

  /// That long after a pose of the path, between its states (pose_at()); none where the path does
  /// not go on.
  std::optional<SE3> after(const SmoothedPose& pose) const;

 private:
  Time delay_;
  Trajectory path_;
};

}  // namespace chasles
