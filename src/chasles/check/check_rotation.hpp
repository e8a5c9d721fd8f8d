#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// How a camera turned, by what it saw.
struct RotationRate {
  Time begin{}, end{};
  Eigen::Vector3d rate_cam = Eigen::Vector3d::Zero();  ///< mean, in camera axes [rad/s]
  /// Inverse of its covariance [s^2/rad^2]: a turn and a step aside look much alike.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

/// A direction seen from two places, in the axes of either.
struct TwoRays {
  Eigen::Vector3d first = Eigen::Vector3d::UnitZ();   ///< of length 1
  Eigen::Vector3d second = Eigen::Vector3d::UnitZ();  ///< of length 1
};

/// How the second of two views is turned against the first.
struct RelativeRotation {
  Eigen::Matrix3d second_R_first = Eigen::Matrix3d::Identity();
  /// Inverse covariance of delta in Exp(delta) second_R_first, whatever the translation [1/rad^2].
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

/// From rays, with a translation that is unknown and may be zero: minimises the robust (Cauchy) sum
/// of the angles between a ray and its epipolar plane, t . (R a x b) / |t x R a|, over R and the
/// direction t (Gauss-Newton). Some of the pairs may be wrong. It begins at `start` or, without
/// one, at the rotation that would explain the rays alone; what lies in a plane is explained by two
/// rotations equally well, and the nearer one is found. None for fewer than 8 pairs, or where it
/// does not converge.
std::optional<RelativeRotation> relative_rotation(const std::vector<TwoRays>& pairs,
                                                  const std::optional<Eigen::Matrix3d>& start = {});

/// Where to begin: second_R_first of the camera for two times; none where it is not known.
using RotationGuess = std::function<std::optional<Eigen::Matrix3d>(Time first, Time second)>;

/// What one camera saw at two times.
struct SeenTwice {
  Time begin{}, end{};
  std::vector<TwoRays> pairs;
};

/// Of one camera of a rig: each frame with the first one at least 0.25 s later, where they have at
/// least 12 common tracks that spread over the image by 10 degrees or more (root mean square). Of a
/// long recording only up to 400 frames, evenly spread.
std::vector<SeenTwice> seen_twice(const std::vector<FeatureFrame>& frames,
                                  const std::vector<Camera>& cameras, int camera);

/// The camera's rotation between the two times of each. No translation or depth is needed.
std::vector<RotationRate> rotation_rates(const std::vector<SeenTwice>& seen,
                                         const RotationGuess& guess = {});

/// The angular rate that an IMU (or a source of body velocities) tells at a time.
struct StampedRate {
  Time time{};
  Eigen::Vector3d rate_imu = Eigen::Vector3d::Zero();  ///< [rad/s]
};

/// How the gyroscope has to be turned, scaled and shifted in time to agree with the images.
/// Standard deviations are those of the noise that remains, whatever its size.
struct GyroscopeFit {
  Eigen::Matrix3d cam_R_imu = Eigen::Matrix3d::Identity();
  double rotation_sigma = 0;  ///< about the axis about which it is known least [rad]
  double gain = 1;            ///< images' rate over the gyroscope's [1]
  double gain_sigma = 0;
  Eigen::Vector3d bias_cam = Eigen::Vector3d::Zero();  ///< rate_cam = gain R rate_imu + it [rad/s]
  double offset = 0;        ///< a camera's stamp t means the gyroscope's t + offset [s]
  double offset_sigma = 0;  ///< [s]
  bool mirrored = false;    ///< a reflection would fit better than any rotation
  std::size_t intervals = 0;
};

/// Fits it over offsets of up to half a second; a constant bias of the gyroscope does not matter.
/// None with fewer than 20 intervals inside the samples, or without any turning.
std::optional<GyroscopeFit> fit_gyroscope(const std::vector<RotationRate>& rates,
                                          const std::vector<StampedRate>& gyroscope);

/// The same from what was seen, in up to eight passes: after the first, the camera's rotations are
/// looked for near those that the gyroscope and the fit before tell, so that a wall does not
/// mislead it.
std::optional<GyroscopeFit> fit_gyroscope(const std::vector<SeenTwice>& seen,
                                          const std::vector<StampedRate>& gyroscope);

}  // namespace chasles
