#pragma once

#include <optional>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/numeric/spline.hpp>
#include <chasles/sim/inertial_path.hpp>
#include <chasles/sim/inertial_settings.hpp>

namespace chasles {

/// Landmark candidates, and the walls that occlude them.
struct InertialWorld {
  std::vector<Eigen::Vector3d> points;  ///< world [m]
  std::vector<Box> walls;
};

/// Whether a wall occludes the line between two points. A point on a wall is not occluded by its
/// own face.
bool blocked(const std::vector<Box>& walls, const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// The settings' cameras, the first at (camera_x, camera_y, camera_z). Its optical axis is the
/// IMU's x axis except for the tilt. The others are beside it, or turned with their place about the
/// IMU's z axis.
std::vector<Camera> make_cameras(const InertialSettings& settings);

/// The pixel of a point in one camera, by the conditions of the settings: inside the image's
/// border, in range, in front of the camera, not occluded.
std::optional<Eigen::Vector2d> visible_pixel(const InertialSettings& settings,
                                             const InertialWorld& world, const Camera& camera,
                                             const SE3& world_T_imu,
                                             const Eigen::Vector3d& p_world);

/// The landmarks and walls of the settings' geometry. `motion` and `cameras` are used by the
/// geometry `trajectory` only: its landmarks are placed at random pixels and depths wherever the
/// first camera sees fewer than `visible_landmarks`.
InertialWorld make_world(const InertialSettings& settings, const Spline& motion,
                         const std::vector<Camera>& cameras);

}  // namespace chasles
