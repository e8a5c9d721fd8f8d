#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include <chasles/base/time.hpp>
#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/frontend/frontend_settings.hpp>

namespace chasles {

/// The rotation between two frames, predicted from a gyroscope.
struct RotationPrior {
  Eigen::Matrix3d now_R_last_imu =
      Eigen::Matrix3d::Identity();  ///< from the IMU axes at the last frame to those at this one
  bool trusted = false;  ///< false: a guess; the search range is larger, and the two-view check
                         ///< estimates the rotation itself
};

/// The tracks of one camera in a frame.
struct CameraReport {
  int found = 0;    ///< present tracks that this camera found; 0 without an image
  int added = 0;    ///< of them, new in this frame
  int matched = 0;  ///< tracks of other cameras that were found in this one
};

/// Outcomes of the tracks in one frame, of all cameras together.
struct FrontendReport {
  Time time{};
  int tracked = 0;          ///< continued from the last frame
  int added = 0;            ///< new in this frame
  int lost_left_image = 0;  ///< left the image or the range of the lens model
  int lost_masked = 0;      ///< entered the mask
  int lost_klt = 0;         ///< not found again
  int lost_backward = 0;    ///< found, but tracking back did not return to the start
  int lost_changed = 0;     ///< no longer similar to the stored patch
  int lost_outlier = 0;     ///< inconsistent with the common motion
  int lost_merged = 0;      ///< met an older track
  int lost_waiting = 0;     ///< no usable image for longer than max_gap

  int missing_images = 0, black_images = 0,
      saturated_images = 0;  ///< cameras without a usable image
  int stereo_tried = 0;      ///< (track, other camera) pairs that were searched
  int stereo_matched = 0;    ///< pairs that were found

  /// The two-view check found a motion that most tracks share, in one of the cameras.
  bool motion_decided = false;
  double rotation_correction = 0;  ///< largest angle between a rotation found and predicted [rad]
  double median_parallax = 0;      ///< largest median of a camera, beyond the rotation [px]

  std::vector<CameraReport> cameras = {};  ///< one a camera

  double mean_age = 0, median_age = 0;  ///< age of the present tracks, in frames

  double pyramid_seconds = 0, follow_seconds = 0, outlier_seconds = 0, corner_seconds = 0,
         stereo_seconds = 0;  ///< time of the stages; no result depends on it

  int lost() const {
    return lost_left_image + lost_masked + lost_klt + lost_backward + lost_changed + lost_outlier +
           lost_merged + lost_waiting;
  }
};

/// From images to numbered points. Corners are followed from frame to frame in the camera that
/// found them, checked against each other, and searched in the other cameras whose views overlap
/// (docs/frontend.md). Camera 0 finds tracks, and so does each camera that sees mostly something
/// else than those before it (rig_overlap.hpp). The same images give the same points; an id is
/// never used twice. Tracks belong to the camera that found them: a landmark that it does not
/// observe is in no frame.
class Frontend {
 public:
  /// `masks`: none, or one image per camera (empty: no mask), 0 where nothing is to be tracked.
  /// Throws UsageError for settings, cameras or masks that cannot be used.
  explicit Frontend(const FrontendSettings& settings, std::vector<Camera> cameras,
                    std::vector<GrayImage> masks = {});
  ~Frontend();
  Frontend(Frontend&&) noexcept;
  Frontend& operator=(Frontend&&) noexcept;

  /// The points of this frame [px], distorted (raw), in the order of cameras and then of ids.
  /// Without a usable image of the camera that found them, tracks wait. Throws InputError,
  /// without a change of state, for a time that does not rise, a wrong number of images, an image
  /// of another size than its camera's, and a matrix that is not a rotation.
  FeatureFrame process(const ImageFrame& frame, const RotationPrior& rotation = {});

  /// Report of the last frame.
  const FrontendReport& report() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace chasles
