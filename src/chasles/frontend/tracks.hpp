#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/frontend/follow.hpp>
#include <chasles/frontend/frontend.hpp>
#include <chasles/frontend/image_pyramid.hpp>

namespace chasles {

/// What is known of a track's point in another camera.
struct OtherView {
  std::optional<Eigen::Vector2d> pixel = {};  ///< in this frame [px]
  std::optional<double> inverse_depth = {};   ///< when it was last seen there [1/m]
  int rests = 0;                              ///< frames in which it is not looked for
};

/// A point of camera 0 that is followed.
struct Track {
  LandmarkId id = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< [px]
  PixelRay ray;                                     ///< of that pixel
  Eigen::Vector2d drift = Eigen::Vector2d::Zero();  ///< motion beyond the rotation [px/s]
  int age = 1;                                      ///< frames in which it was seen
  std::vector<OtherView> others = {};               ///< cameras 1, 2, ...
};

/// From one image of camera 0 to the next.
struct TrackingStep {
  const Camera& camera;
  const ImagePyramid& last;
  const ImagePyramid& now;
  const GrayImage& mask;
  Eigen::Matrix3d now_R_last;  ///< of the camera
  bool trusted = false;        ///< that rotation is more than a guess
  double seconds = 0;          ///< between the images
};

/// What the settings mean for a single patch.
FollowSettings follow_settings_of(const FrontendSettings& settings);

/// Moves each track to the new image; those that end are taken out and counted in the report.
void follow_tracks(const TrackingStep& step, const FrontendSettings& settings,
                   std::vector<Track>& tracks, FrontendReport& report);

}  // namespace chasles
