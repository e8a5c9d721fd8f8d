#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/frontend/follow.hpp>
#include <chasles/frontend/image_pyramid.hpp>

namespace chasles {

/// Two cameras of a rig and their images at one instant.
struct StereoViews {
  const Camera& first;
  const ImagePyramid& first_image;
  const Camera& other;
  const ImagePyramid& other_image;
  SE3 other_T_first;  ///< of the cameras
  bool bends;         ///< they look into different directions: patches need transfer_bow()

  StereoViews(const Camera& first_camera, const ImagePyramid& first_pyramid,
              const Camera& other_camera, const ImagePyramid& other_pyramid)
      : first(first_camera),
        first_image(first_pyramid),
        other(other_camera),
        other_image(other_pyramid),
        other_T_first(other_camera.cam_T_imu * first_camera.cam_T_imu.inverse()),
        bends(other_T_first.R(2, 2) < kAlike) {}

  /// Cosine of 11 degrees. With less the bow of a patch is below 0.05 px.
  static constexpr double kAlike = 0.98;
};

struct StereoMatchSettings {
  FollowSettings follow;
  double epipolar_threshold = 1.0;  ///< [px]
  double min_depth = 0.3;           ///< depth of the nearest point of the search [m]
};

/// A pixel of the first camera with its ray, and its predicted inverse depth if known.
struct StereoQuery {
  Eigen::Vector2d pixel;
  WideRay ray;
  std::optional<double> inverse_depth = {};  ///< predicted, as in StereoMatch [1/m]
};

/// The same point in the other camera.
struct StereoMatch {
  Eigen::Vector2d pixel;  ///< in the other image [px]
  /// Along the first camera's axis, or along a ray that is not ahead (is_ahead) [1/m]; about 0 at
  /// infinity.
  double inverse_depth = 0;
};

/// Finds a pixel of the first camera in the other one. The search starts at the predicted depth. If
/// that fails, or without a prediction, it searches the whole epipolar curve on a coarse level and
/// refines the two best candidates. A match must lie on the curve, be in front of both cameras,
/// correlate well, and pass the backward check. If two different candidates pass, the better one
/// must be clearly better.
std::optional<StereoMatch> match_stereo(const StereoViews& views, const StereoQuery& query,
                                        const StereoMatchSettings& settings);

/// Checks a pair of pixels against the rig's geometry only. None if it is off the epipolar curve,
/// or beyond infinity, by more than `threshold` [rad].
std::optional<StereoMatch> triangulate_match(const StereoViews& views, const WideRay& first,
                                             const Eigen::Vector2d& other_pixel, double threshold);

}  // namespace chasles
