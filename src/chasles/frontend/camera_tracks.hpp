#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <chasles/base/time.hpp>
#include <chasles/camera/camera.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/frontend/coverage.hpp>
#include <chasles/frontend/frontend.hpp>
#include <chasles/frontend/image_pyramid.hpp>
#include <chasles/frontend/tracks.hpp>

namespace chasles {

/// The tracks that one camera finds: they are followed from image to image of this camera, and new
/// ones begin where they are fewest. Images of other cameras do not matter here.
class CameraTracks {
 public:
  /// `cameras`: of the rig. `max_tracks`: the share of this camera.
  CameraTracks(const FrontendSettings& settings, const Camera& camera, const GrayImage& mask,
               std::size_t cameras, int max_tracks);

  /// Call in each frame, also in those without an image of this camera: the rotation accumulates.
  void turn(const RotationPrior& rotation);
  /// Ends the tracks if the last image is too long ago: a patch that is found again after a long
  /// gap may be another one.
  void end_after_gap(Time time, FrontendReport& report);
  /// Moves the tracks to the image `now`.
  void follow(const ImagePyramid& now, Time time, FrontendReport& report);
  /// Adds tracks where `now` has few, at a distance from all others and from the pixels `taken`.
  /// Their ids begin at `next_id`, which rises. Returns the index of the first new track.
  std::size_t add(const ImagePyramid& now, const std::vector<Eigen::Vector2d>& taken,
                  LandmarkId& next_id, FrontendReport& report);
  /// Call at the end of a frame with an image, which is taken by swap.
  void keep(ImagePyramid& now) { past_.push(now); }

  std::vector<Track>& tracks() { return tracks_; }
  const std::vector<Track>& tracks() const { return tracks_; }

 private:
  FrontendSettings settings_;
  Camera camera_;
  GrayImage mask_;
  std::size_t cameras_;
  Coverage coverage_;
  Time last_image_{};  // of the last one in `past_`
  PastImages past_;    // up to the previous one
  std::vector<Track> tracks_;
  Eigen::Matrix3d now_R_last_imu_ = Eigen::Matrix3d::Identity();  // since that image
  bool rotation_trusted_ = true;
};

}  // namespace chasles
