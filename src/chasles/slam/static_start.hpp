#pragma once

#include <span>
#include <vector>

#include <chasles/slam/inertial_start.hpp>
#include <chasles/slam/initialiser_settings.hpp>

namespace chasles {

/// What a window of samples says if nothing moved in it.
struct RestMeans {
  double seconds = 0;                                            ///< the window
  Eigen::Vector3d specific_force_imu = Eigen::Vector3d::Zero();  ///< mean [m/s^2]
  Eigen::Vector3d angular_rate_imu = Eigen::Vector3d::Zero();    ///< mean [rad/s]
  double accelerometer_deviation = 0, gyroscope_deviation = 0;   ///< rms of an axis about the mean
  double accelerometer_expected = 0, gyroscope_expected = 0;     ///< of the stated noise
};

/// Means and deviations of at least two samples; the expected deviation is density * sqrt(rate).
RestMeans rest_means(std::span<const ImuSample> samples, const ImuNoise& noise);

/// The start at rest: gravity from the mean specific force, heading 0 (the shortest rotation that
/// takes it to nav's vertical), the mean rate as gyroscope bias, velocity 0. With the prior of the
/// biases and a force f = R^T (-g) + b_a + n, linear in tilt and b_a, the covariance is exact to
/// first order: a horizontal bias cannot be told from tilt (theta = z x (b_a + n) / g), and the
/// norm of f tells the bias along gravity. White noise counts as it was measured where that is more
/// than was stated. The window is used up: the filter begins at its end.
InertialStart static_start(Time end, const RestMeans& means, const ImuNoise& noise,
                           const InitialiserSettings& settings);

}  // namespace chasles
