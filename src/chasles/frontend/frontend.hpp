#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/frontend/frontend_settings.hpp>
#include <chasles/time.hpp>

namespace chasles {

/// What a gyroscope says about the time between two frames.
struct RotationPrior {
  Eigen::Matrix3d now_R_last_imu =
      Eigen::Matrix3d::Identity();  ///< from the IMU's axes at the last
                                    ///< frame to those at this one
  bool trusted = false;  ///< false: a guess; tracks are looked for further away, and the two-view
                         ///< check finds the rotation itself
};

/// What became of the tracks in one frame.
struct FrontendReport {
  Time time{};
  int tracked = 0;          ///< went on from the last frame
  int added = 0;            ///< began in this one
  int lost_left_image = 0;  ///< or where the lens model ends
  int lost_masked = 0;      ///< went behind the mask
  int lost_klt = 0;         ///< were not found again
  int lost_backward = 0;    ///< were found, but did not lead back
  int lost_changed = 0;     ///< no longer look like the patch that was kept
  int lost_outlier = 0;     ///< moved otherwise than the others
  int lost_merged = 0;      ///< ran into an older track
  int lost_waiting = 0;     ///< outlived too many frames without an image

  int missing_images = 0, black_images = 0, saturated_images = 0;  ///< cameras without a usable one
  int stereo_tried = 0;    ///< (track, other camera) pairs that were looked for
  int stereo_matched = 0;  ///< and found

  bool motion_decided = false;     ///< the two-view check found a motion that most tracks share
  double rotation_correction = 0;  ///< angle between its rotation and the one given [rad]
  double median_parallax = 0;      ///< of the tracks, beyond the rotation given [px]

  double mean_age = 0, median_age = 0;  ///< frames in which the present tracks were seen

  double pyramid_seconds = 0, follow_seconds = 0, outlier_seconds = 0, corner_seconds = 0,
         stereo_seconds = 0;  ///< what the stages took; no result depends on it

  int lost() const {
    return lost_left_image + lost_masked + lost_klt + lost_backward + lost_changed + lost_outlier +
           lost_merged + lost_waiting;
  }
};

/// From images to numbered points: corners of camera 0 are followed from frame to frame, checked
/// against each other, and found in the other cameras of the rig (docs/frontend.md). The same
/// images give the same points; an id is never used twice. Tracks belong to camera 0: a landmark
/// that it does not see is in no frame.
class Frontend {
 public:
  /// `masks`: none, or one image a camera (empty: no mask), 0 where nothing is to be tracked.
  /// Throws UsageError for settings, cameras or masks that cannot be used.
  explicit Frontend(const FrontendSettings& settings, std::vector<Camera> cameras,
                    std::vector<GrayImage> masks = {});
  ~Frontend();
  Frontend(Frontend&&) noexcept;
  Frontend& operator=(Frontend&&) noexcept;

  /// The points that this frame shows, raw pixels, in the order of cameras and then of ids. Without
  /// a usable image of camera 0 the frame is empty and the tracks wait. Throws InputError, and
  /// remains as it was, for a time that does not rise, another number of images than cameras, an
  /// image of another size than its camera's, and a matrix that is no rotation.
  FeatureFrame process(const ImageFrame& frame, const RotationPrior& rotation = {});

  /// About the last frame.
  const FrontendReport& report() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace chasles
