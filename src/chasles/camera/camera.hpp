#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include <chasles/base/settings.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

/// Lens distortion model; the coefficients are those of Kalibr and OpenCV.
enum class Distortion {
  kNone,
  kRadtan,       ///< Brown-Conrady: k1, k2, p1, p2, and k3 in `radtan_k3`
  kEquidistant,  ///< Kannala-Brandt: k1, k2, k3, k4
};

template <>
struct Choices<Distortion> {
  static constexpr std::array list{Choice{Distortion::kNone, "none"},
                                   Choice{Distortion::kRadtan, "radtan"},
                                   Choice{Distortion::kEquidistant, "equidistant"}};
};

/// One camera of a rig. Camera frame: z forward, x right, y down.
struct Camera {
  int width = 0, height = 0;  ///< [px]
  double fx = 0, fy = 0;      ///< focal lengths [px]
  double cx = 0, cy = 0;      ///< principal point [px]
  Distortion distortion = Distortion::kNone;
  Eigen::Vector4d coefficients = Eigen::Vector4d::Zero();
  SE3 cam_T_imu;         ///< maps IMU coordinates to those of the camera
  double radtan_k3 = 0;  ///< fifth coefficient of kRadtan; 0 in other models
};

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

/// The ray of a pixel: the inverse of project, by Newton's method to round-off. None where it does
/// not converge (outside the range of the lens model), for example 90 degrees or more off the axis
/// of a fisheye camera.
std::optional<PixelRay> unproject(const Camera& camera, const Eigen::Vector2d& pixel);

/// Whether a pixel lies in the image, at least `border` pixels from its edge.
bool in_image(const Camera& camera, const Eigen::Vector2d& pixel, double border = 0);

}  // namespace chasles
