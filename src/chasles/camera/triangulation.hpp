#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>

namespace chasles {

/// One observation of a point: pose, camera and pixel.
struct View {
  SE3 world_T_imu;
  const Camera* camera = nullptr;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

/// A point triangulated from several views.
struct MultiViewPoint {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  ///< [m^2], for 1 px noise in every view and exact poses
  double rms = 0;               ///< of the reprojection errors [px]
  double parallax = 0;          ///< largest angle between two views' rays [rad]
};

/// The point of least squared reprojection error. A linear solution from the rays is followed by
/// Gauss-Newton steps with Levenberg's damping, to convergence. The coordinates are inverse depth
/// in the view nearest to the middle (Montiel, Civera & Davison 2006), in the axes of its ray's
/// face (anchor_face.hpp). The covariance is the inverse of the normal matrix at the solution.
///
/// None with fewer than two views, and if a camera is missing, a pose or pixel is not finite, or a
/// pixel has no direction (bearing). None without parallax: the camera centres coincide to
/// round-off, all lie on the ray through the point (the normal matrix is singular to working
/// precision), or the rays are parallel or diverge. None if a camera does not see the point, or it
/// is nearer than kMinDepth (project). Small parallax is accepted and gives a large covariance.
std::optional<MultiViewPoint> triangulate(std::span<const View> views);

}  // namespace chasles
