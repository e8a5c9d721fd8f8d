#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// The mean angular rate of a camera between two frames, determined from its tracks.
struct RotationRate {
  Time begin{}, end{};
  Eigen::Vector3d rate_cam = Eigen::Vector3d::Zero();  ///< mean, in camera axes [rad/s]
  /// Inverse covariance of the rate [s^2/rad^2]. Rotation and sideways translation have similar
  /// effects on the tracks, so the axes differ.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

/// The rays to one point from two views, each in the axes of its own view.
struct TwoRays {
  Eigen::Vector3d first = Eigen::Vector3d::UnitZ();   ///< of length 1
  Eigen::Vector3d second = Eigen::Vector3d::UnitZ();  ///< of length 1
  /// Rows of the two pixels from the middle of the image, over its height; 0 without a height.
  double first_row = 0, second_row = 0;
  /// Derivatives of the rays' angles from the optical axis by the logarithm of the pixels'
  /// distances from the principal point: what a shorter focal length adds [rad].
  double first_stretch = 0, second_stretch = 0;
};

/// The rotation of the second of two views relative to the first.
struct RelativeRotation {
  Eigen::Matrix3d second_R_first = Eigen::Matrix3d::Identity();
  /// Inverse covariance of delta in Exp(delta) second_R_first, whatever the translation [1/rad^2].
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

/// Estimates the rotation from rays; the translation is unknown and may be zero. Minimises the
/// robust (Cauchy) sum of the angles between a ray and its epipolar plane, t . (R a x b) / |t x R
/// a|, over R and the direction t, by Gauss-Newton. Some of the pairs may be outliers. The initial
/// value is `start` or, without one, the rotation that best aligns the rays. Points in one plane
/// admit two solutions; the one nearer to the initial value is found. Returns nothing for fewer
/// than 8 pairs, or without convergence.
std::optional<RelativeRotation> relative_rotation(const std::vector<TwoRays>& pairs,
                                                  const std::optional<Eigen::Matrix3d>& start = {});

/// Initial value: second_R_first of the camera for two times; nothing if unknown.
using RotationGuess = std::function<std::optional<Eigen::Matrix3d>(Time first, Time second)>;

/// The common tracks of one camera at two times.
struct SeenTwice {
  Time begin{}, end{};
  std::vector<TwoRays> pairs;
};

/// For one camera of a rig: pairs each frame with the first one at least 0.25 s later, if they have
/// at least 12 common tracks that spread over the image by 10 degrees or more (root mean square).
/// Uses up to 400 frames of a long recording, evenly spread.
std::vector<SeenTwice> seen_twice(const std::vector<FeatureFrame>& frames,
                                  const std::vector<Camera>& cameras, int camera);

/// The camera's rotation between the two times of each pair. Needs no translation and no depth.
std::vector<RotationRate> rotation_rates(const std::vector<SeenTwice>& seen,
                                         const RotationGuess& guess = {});

/// The angular rate of an IMU, or of a source of body velocities, at a time.
struct StampedRate {
  Time time{};
  Eigen::Vector3d rate_imu = Eigen::Vector3d::Zero();  ///< [rad/s]
};

/// The rotation, scale, bias and time offset with which the gyroscope agrees with the images. The
/// standard deviations are scaled to the residuals of the fit.
struct GyroscopeFit {
  Eigen::Matrix3d cam_R_imu = Eigen::Matrix3d::Identity();
  double rotation_sigma = 0;  ///< about the least certain axis [rad]
  double gain = 1;            ///< images' rate over the gyroscope's [1]
  double gain_sigma = 0;
  Eigen::Vector3d bias_cam =
      Eigen::Vector3d::Zero();  ///< rate_cam = gain R rate_imu + bias_cam [rad/s]
  double offset = 0;            ///< camera time + offset = gyroscope time [s]
  double offset_sigma = 0;      ///< [s]
  bool mirrored = false;        ///< a reflection fits better than any rotation
  std::size_t intervals = 0;
};

/// Fits the parameters, with offsets of up to half a second. A constant gyroscope bias has no
/// effect on the others. Returns nothing for fewer than 20 intervals within the samples, or without
/// rotation.
std::optional<GyroscopeFit> fit_gyroscope(const std::vector<RotationRate>& rates,
                                          const std::vector<StampedRate>& gyroscope);

/// The same from pairs of frames, in up to `passes` passes. After the first pass, each camera
/// rotation is initialised from the gyroscope and the previous fit, so that a plane does not lead
/// to the wrong solution.
std::optional<GyroscopeFit> fit_gyroscope(const std::vector<SeenTwice>& seen,
                                          const std::vector<StampedRate>& gyroscope,
                                          int passes = 8);

/// The same from a fit near the solution, from which the first pass is initialised as well.
std::optional<GyroscopeFit> fit_gyroscope_from(const GyroscopeFit& start,
                                               const std::vector<SeenTwice>& seen,
                                               const std::vector<StampedRate>& gyroscope,
                                               int passes = 8);

}  // namespace chasles
