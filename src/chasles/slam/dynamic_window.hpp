#pragma once

#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/imu/strapdown.hpp>

namespace chasles {

/// One look at a track, without its lens: where its ray meets the plane at unit focal length, and
/// what makes a difference there a number of standard deviations.
struct PlaneView {
  int keyframe = 0, camera = 0;
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();         ///< (x/z, y/z) in the camera's frame
  Eigen::Matrix2d whitening = Eigen::Matrix2d::Zero();  ///< (sigma d xy / d pixel)^-1
  Eigen::Vector3d ray_imu = Eigen::Vector3d::Zero();    ///< unit length, IMU axes
  double angle_sigma = 0;                               ///< of the ray [rad]
};

/// The views of one track, by keyframe and camera; two at least.
using PlaneTrack = std::vector<PlaneView>;

/// What a start in motion is made of: some frames, the tracks that they see, and the IMU between.
struct MotionWindow {
  std::vector<Time> times;                          ///< of the keyframes
  std::vector<std::vector<ImuInterval>> intervals;  ///< from keyframe k to k + 1
  std::vector<SE3> cam_T_imu, imu_T_cam;            ///< of the cameras
  std::vector<double> focal;                        ///< of the cameras, mean of fx and fy [px]
  std::vector<PlaneTrack> tracks;                   ///< of three keyframes at least
  int stereo_tracks = 0;                            ///< with two cameras at one keyframe
};

/// The keyframes of a window: `count` of its frames, evenly, with the first and the last.
std::vector<std::size_t> choose_keyframes(std::size_t frames, int count);

/// The tracks of those frames, the best covered first, at most `max_tracks`; of a repeated
/// observation the first counts, and one of an unknown camera, without a ray or not finite is left
/// out. `intervals` stays empty.
MotionWindow make_window(const std::vector<FeatureFrame>& keyframes,
                         const std::vector<Camera>& cameras, double pixel_sigma, int max_tracks);

/// Of all its tracks.
int views_of(const MotionWindow& window);

}  // namespace chasles
