#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
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

/// Where a track's patch was taken. From image to image errors add up; against one patch that is
/// kept for many images they do not.
struct PatchAnchor {
  int image = 0;                                               ///< its number
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();             ///< there [px]
  Eigen::Matrix2d now_A_then = Eigen::Matrix2d::Identity();    ///< d pixel now / d pixel there
  Eigen::Matrix2d then_A_first = Eigen::Matrix2d::Identity();  ///< since the track began
};

/// A point of camera 0 that is followed.
struct Track {
  LandmarkId id = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< [px]
  PixelRay ray;                                     ///< of that pixel
  Eigen::Vector2d drift = Eigen::Vector2d::Zero();  ///< motion beyond the rotation [px/s]
  int age = 1;                                      ///< frames in which it was seen
  PatchAnchor anchor = {};
  std::vector<OtherView> others = {};  ///< cameras 1, 2, ...
};

/// The latest images of camera 0, by their numbers 0, 1, 2, ...
class PastImages {
 public:
  /// So many of the latest are kept; at least the last one.
  explicit PastImages(int count) : images_(static_cast<std::size_t>(std::max(count, 1))) {}

  /// Takes an image over; `image` gets the memory of one that is forgotten.
  void push(ImagePyramid& image) { std::swap(images_[slot(count_++)], image); }
  int count() const { return count_; }
  /// One of those that are kept.
  const ImagePyramid& at(int number) const { return images_[slot(number)]; }
  const ImagePyramid& last() const { return at(count_ - 1); }

 private:
  std::size_t slot(int number) const { return static_cast<std::size_t>(number) % images_.size(); }

  std::vector<ImagePyramid> images_;
  int count_ = 0;
};

/// From one image of camera 0 to the next.
struct TrackingStep {
  const Camera& camera;
  const PastImages& past;
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
