#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <chasles/camera/camera.hpp>
#include <chasles/target/target.hpp>

namespace chasles {

/// The pose of a target in the frame of a camera, and how well it explains the corners.
struct TargetPose {
  SE3 cam_T_target;
  double rms = 0;  ///< of the pixel errors [px]
};

/// The pose of a flat target from its corners in one image: a homography of the bearings, then
/// least squares of the pixels under Huber's loss of `loss_width` [px]. Any lens, also beyond 90
/// degrees from its axis. None with fewer than four corners, where they are on a line, or without a
/// pose that has the target's front before the camera.
std::optional<TargetPose> target_pose(const Camera& camera,
                                      std::span<const Eigen::Vector3d> corners,
                                      const TargetView& view, double loss_width = 1);

/// The same from a pose near to it.
std::optional<TargetPose> refined_pose(const Camera& camera,
                                       std::span<const Eigen::Vector3d> corners,
                                       const TargetView& view, const SE3& cam_T_target,
                                       double loss_width = 1);

/// Whether a view shows the side of a flat target that its z axis points away from, as of boards
/// whose y axis points down.
bool is_seen_from_behind(std::span<const Eigen::Vector3d> corners, const TargetView& view);

}  // namespace chasles
