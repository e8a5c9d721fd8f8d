#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/frontend/follow.hpp>
#include <chasles/frontend/image_pyramid.hpp>

namespace chasles {

/// Two cameras of a rig with what they saw at one instant.
struct StereoViews {
  const Camera& first;
  const ImagePyramid& first_image;
  const Camera& other;
  const ImagePyramid& other_image;
  SE3 other_T_first;  ///< of the cameras

  StereoViews(const Camera& first_camera, const ImagePyramid& first_pyramid,
              const Camera& other_camera, const ImagePyramid& other_pyramid)
      : first(first_camera),
        first_image(first_pyramid),
        other(other_camera),
        other_image(other_pyramid),
        other_T_first(other_camera.cam_T_imu * first_camera.cam_T_imu.inverse()) {}
};

struct StereoMatchSettings {
  FollowSettings follow;
  double epipolar_threshold = 1.0;  ///< [px]
  double min_depth = 0.3;           ///< nearest point that is looked for [m]
};

/// A pixel of the first camera: with its ray, and its inverse depth if one is known.
struct StereoQuery {
  Eigen::Vector2d pixel;
  PixelRay ray;
  std::optional<double> inverse_depth = {};  ///< expected, along the camera's axis [1/m]
};

/// The same point in the other camera.
struct StereoMatch {
  Eigen::Vector2d pixel;     ///< in the other image [px]
  double inverse_depth = 0;  ///< along the first camera's axis [1/m]; at infinity 0, give or take
};

/// Finds a pixel of the first camera in the other one. With an expected depth it starts there; if
/// that fails or there is none, it looks along the whole epipolar curve on a coarse level, and
/// follows the two best places down. A match lies on the curve, in front of both cameras,
/// correlates well, and is followed back to where it came from; where two different places pass,
/// the better one must be clearly better.
std::optional<StereoMatch> match_stereo(const StereoViews& views, const StereoQuery& query,
                                        const StereoMatchSettings& settings);

/// Checks one pair of pixels against the rig's geometry alone; none if it is off the epipolar curve
/// by more than `threshold` [rad], or before the cameras' infinity by more than that.
std::optional<StereoMatch> triangulate_match(const StereoViews& views, const PixelRay& first,
                                             const Eigen::Vector2d& other_pixel, double threshold);

}  // namespace chasles
