#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>

namespace chasles {

/// One look at a point: from where, with which camera, at which pixel.
struct View {
  SE3 world_T_imu;
  const Camera* camera = nullptr;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

/// A point that several views agree on.
struct MultiViewPoint {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();     ///< [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< for 1 px in every view, poses exact
  double rms = 0;                                        ///< of the reprojection residuals [px]
  double parallax = 0;  ///< largest angle between two views' rays [rad]
};

/// The point of least squared reprojection error: a linear start from the rays, then Gauss-Newton
/// with Levenberg's damping in inverse-depth coordinates of the view nearest to the middle, to
/// convergence (Montiel, Civera & Davison 2006 for the coordinates). The covariance is the inverse
/// of the normal matrix there.
///
/// None with fewer than two views; where a camera is missing, a pose or pixel is not finite or a
/// pixel has no ray (unproject); without parallax, that is where the cameras' centres coincide to
/// round-off, all lie on the ray through the point (the normal matrix is singular to working
/// precision) or the rays are parallel or diverge; and where the point ends behind a camera or
/// nearer than kMinDepth (stereo.hpp). Little parallax is not none: the covariance says how little.
std::optional<MultiViewPoint> triangulate(std::span<const View> views);

}  // namespace chasles
