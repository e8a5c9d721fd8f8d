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

/// The pixel of a point in the camera's frame [m]. None where the lens model folds over (its radial
/// derivative is not positive), and none nearer than kMinDepth (stereo.hpp): to the plane z = 0 for
/// a lens model that ends before 90 degrees from the axis, to the camera for the others, which see
/// points behind that plane, too. Straight behind the camera there is no pixel. The pixel may lie
/// outside the image: see in_image.
std::optional<PixelProjection> project(const Camera& camera, const Eigen::Vector3d& p_cam);

/// d pixel / d (fx, fy, cx, cy, coefficients of the lens model).
using ParameterDerivative =
    Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 4 + static_cast<int>(LensCoefficients::kMost)>;

/// The derivative of the pixel of a point by the camera's parameters; none where project is none.
std::optional<ParameterDerivative> parameter_derivative(const Camera& camera,
                                                        const Eigen::Vector3d& p_cam);

/// A direction and its derivative.
struct PixelRay {
  Eigen::Vector3d ray;                  ///< (x/z, y/z, 1) in the camera's frame
  Eigen::Matrix<double, 2, 2> d_pixel;  ///< d (x/z, y/z) / d pixel  [1/px]
};

/// The ray of a pixel in front of the camera: the inverse of project, to round-off. None outside
/// the range of the lens model, and 90 degrees or more from the axis: see bearing.
std::optional<PixelRay> unproject(const Camera& camera, const Eigen::Vector2d& pixel);

/// A unit vector in the camera's frame and its derivative.
struct PixelBearing {
  Eigen::Vector3d bearing;
  Eigen::Matrix<double, 3, 2> d_pixel;  ///< d bearing / d pixel, across the bearing  [rad/px]
};

/// The direction of a pixel, at any angle from the axis: the inverse of project, to round-off. None
/// outside the range of the lens model.
std::optional<PixelBearing> bearing(const Camera& camera, const Eigen::Vector2d& pixel);

/// Whether the camera's lens model goes on beyond 90 degrees from the axis.
bool sees_beside(const Camera& camera);

/// Whether a direction in the camera's frame is less than 80 degrees from the axis. Farther out,
/// (x/z, y/z) is a poor measure of it.
bool is_ahead(const Eigen::Vector3d& p_cam);

/// A vector along a pixel's direction and its derivative.
struct WideRay {
  Eigen::Vector3d ray;
  Eigen::Matrix<double, 3, 2> d_pixel;  ///< d ray / d pixel  [1/px]
};

/// As bearing, but that the vector is (x/z, y/z, 1) where it is ahead (is_ahead).
std::optional<WideRay> wide_ray(const Camera& camera, const Eigen::Vector2d& pixel);

/// Whether a pixel lies in the image, at least `border` pixels from its edge.
bool in_image(const Camera& camera, const Eigen::Vector2d& pixel, double border = 0);

}  // namespace chasles
