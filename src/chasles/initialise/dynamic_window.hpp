#pragma once

#include <span>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/filter/readout.hpp>
#include <chasles/imu/strapdown.hpp>

namespace chasles {

/// One undistorted observation of a track: the intersection of its ray with the plane at unit focal
/// length, in the axes of the ray's face (camera/anchor_face.hpp), and the whitening that scales a
/// difference there to standard deviations.
struct PlaneView {
  int keyframe = 0, camera = 0;
  int axes = 0;                                         ///< index into the window's cam_T_imu
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();         ///< (x/z, y/z) in these axes
  Eigen::Matrix2d whitening = Eigen::Matrix2d::Zero();  ///< (sigma d xy / d pixel)^-1
  Eigen::Vector3d ray_imu = Eigen::Vector3d::Zero();    ///< unit length, IMU axes
  double angle_sigma = 0;                               ///< of the ray [rad]
  /// Of the pixel's line (camera/rolling_shutter.hpp): how long after the keyframe [s], and the
  /// rotation from the IMU's axes then to those at the keyframe, which ray_imu has.
  double delay = 0;
  Eigen::Matrix3d imu_R_line = Eigen::Matrix3d::Identity();
};

/// The views of one track, by keyframe and camera; at least two.
using PlaneTrack = std::vector<PlaneView>;

/// The data of a dynamic initialisation: some frames, the tracks that they observe, and the IMU
/// intervals between them.
struct MotionWindow {
  std::vector<Time> times;                          ///< of the keyframes
  std::vector<std::vector<ImuInterval>> intervals;  ///< from keyframe k to k + 1
  std::vector<SE3> cam_T_imu, imu_T_cam;            ///< of the cameras, then of their other faces
  std::vector<double> focal;                        ///< for each camera, the mean of fx and fy [px]
  std::vector<PlaneTrack> tracks;                   ///< with views in at least three keyframes
  int stereo_tracks = 0;                            ///< observed by two cameras at one keyframe
  std::vector<MeasuredReadout> readouts;            ///< after the keyframes
};

/// Indices of the keyframes of a window: `count` of its frames, evenly spaced, including the first
/// and the last.
std::vector<std::size_t> choose_keyframes(std::size_t frames, int count);

/// The tracks of those frames, those with most views first, at most `max_tracks`. Of a repeated
/// observation the first counts. An observation that is not finite, has no ray or belongs to an
/// unknown camera is dropped. `intervals` stays empty. `readouts`: what the IMU measured after each
/// keyframe, for cameras with a rolling shutter.
MotionWindow make_window(const std::vector<FeatureFrame>& keyframes,
                         const std::vector<Camera>& cameras, double pixel_sigma, int max_tracks,
                         std::vector<MeasuredReadout> readouts = {});

/// The number of views of all tracks.
int views_of(const MotionWindow& window);

}  // namespace chasles
