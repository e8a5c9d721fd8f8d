#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/camera/lenses/lens_model.hpp>
#include <chasles/camera/rolling_shutter.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

/// One camera of a rig. Camera frame: z forward, x right, y down.
struct Camera {
  int width = 0, height = 0;  ///< [px]
  /// Pixels of a unit of the lens model's plane. With none, radtan and equidistant these are the
  /// focal lengths; see focal_lengths_at_axis.
  double fx = 0, fy = 0;
  double cx = 0, cy = 0;  ///< principal point [px]
  Distortion distortion = Distortion::kNone;
  LensCoefficients coefficients = {};  ///< of the lens model, in the order of its list
  SE3 cam_T_imu;                       ///< maps IMU coordinates to those of the camera
  Shutter shutter = {};
};

/// The focal lengths on the optical axis: pixels of a unit of x/z and of y/z there [px].
Eigen::Vector2d focal_lengths_at_axis(const Camera& camera);

/// A projection and its derivative.
struct PixelProjection {
  Eigen::Vector2d pixel;                ///< [px]
  Eigen::Matrix<double, 2, 3> d_point;  ///< d pixel / d p_cam  [px/m]
};

/// The pixel of a point in the camera's frame [m]. None if the point lies behind the camera or
/// nearer than kMinDepth (stereo.hpp), or where the lens model folds over (its radial derivative is
/// not positive). The pixel may lie outside the image: see in_image.
std::optional<PixelProjection> project(const Camera& camera, const Eigen::Vector3d& p_cam);

/// A direction and its derivative.
struct PixelRay {
  Eigen::Vector3d ray;                  ///< (x/z, y/z, 1) in the camera's frame
  Eigen::Matrix<double, 2, 2> d_pixel;  ///< d (x/z, y/z) / d pixel  [1/px]
};

/// The ray of a pixel: the inverse of project, to round-off. None outside the range of the lens
/// model, for example 90 degrees or more off the axis of a fisheye camera.
std::optional<PixelRay> unproject(const Camera& camera, const Eigen::Vector2d& pixel);

/// Whether a pixel lies in the image, at least `border` pixels from its edge.
bool in_image(const Camera& camera, const Eigen::Vector2d& pixel, double border = 0);

}  // namespace chasles
