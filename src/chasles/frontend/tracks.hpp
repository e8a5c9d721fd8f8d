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

/// A track's point in another camera.
struct OtherView {
  std::optional<Eigen::Vector2d> pixel = {};  ///< in this frame [px]
  std::optional<double> inverse_depth = {};   ///< at its last match there [1/m]
  int pause = 0;                              ///< frames for which the search is skipped
};

/// The origin of a track's patch. Errors accumulate when following from image to image; they do not
/// against one patch that is kept for many images.
struct PatchAnchor {
  int image = 0;                                               ///< number of the image
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();             ///< in that image [px]
  Eigen::Matrix2d now_A_then = Eigen::Matrix2d::Identity();    ///< d pixel now / d pixel then
  Eigen::Matrix2d then_A_first = Eigen::Matrix2d::Identity();  ///< since the start of the track
};

/// A feature that is followed in the camera that found it.
struct Track {
  LandmarkId id = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< [px]
  WideRay ray;                                      ///< of the pixel
  Eigen::Vector2d drift = Eigen::Vector2d::Zero();  ///< motion beyond the rotation [px/s]
  int age = 1;                                      ///< frames with an observation
  PatchAnchor anchor = {};
  std::vector<OtherView> others = {};  ///< one a camera; its own is not used
};

/// The latest images of a camera, numbered 0, 1, 2, ...
class PastImages {
 public:
  /// `count`: number of images to keep, at least one.
  explicit PastImages(int count) : images_(static_cast<std::size_t>(std::max(count, 1))) {}

  /// Stores an image by swap; `image` receives the memory of a removed one.
  void push(ImagePyramid& image) { std::swap(images_[slot(count_++)], image); }
  int count() const { return count_; }
  /// The image with this number, which must be among those kept.
  const ImagePyramid& at(int number) const { return images_[slot(number)]; }
  const ImagePyramid& last() const { return at(count_ - 1); }

 private:
  std::size_t slot(int number) const { return static_cast<std::size_t>(number) % images_.size(); }

  std::vector<ImagePyramid> images_;
  int count_ = 0;
};

/// Input of tracking from one image of a camera to the next.
struct TrackingStep {
  const Camera& camera;
  const PastImages& past;
  const ImagePyramid& now;
  const GrayImage& mask;
  Eigen::Matrix3d now_R_last;  ///< of the camera
  bool trusted = false;        ///< the rotation is measured, not assumed
  double seconds = 0;          ///< between the images
};

/// Two tracks nearer than this are one [px].
inline constexpr double kMergeDistance = 3;

/// The settings for a single patch.
FollowSettings follow_settings_of(const FrontendSettings& settings);

/// Moves each track to the new image. Tracks that end are removed and counted in the report,
/// beside those of other cameras in the frame.
void follow_tracks(const TrackingStep& step, const FrontendSettings& settings,
                   std::vector<Track>& tracks, FrontendReport& report);

}  // namespace chasles
