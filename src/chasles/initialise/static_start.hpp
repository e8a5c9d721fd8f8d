#pragma once

#include <span>
#include <vector>

#include <chasles/initialise/inertial_start.hpp>
#include <chasles/initialise/initialiser_settings.hpp>

namespace chasles {

/// Statistics of a window of samples, for a static initialisation.
struct StandstillMeans {
  double seconds = 0;                                            ///< length of the window
  Eigen::Vector3d specific_force_imu = Eigen::Vector3d::Zero();  ///< mean [m/s^2]
  Eigen::Vector3d angular_rate_imu = Eigen::Vector3d::Zero();    ///< mean [rad/s]
  double accelerometer_sigma = 0, gyroscope_sigma = 0;           ///< rms of one axis about the mean
  double accelerometer_expected = 0, gyroscope_expected = 0;     ///< from the stated noise
};

/// Means and standard deviations of at least two samples. The expected standard deviation is
/// density * sqrt(rate).
StandstillMeans standstill_means(std::span<const ImuSample> samples, const ImuNoise& noise);

/// The static initialisation. Gravity comes from the mean specific force, the gyroscope bias from
/// the mean rate. The velocity is 0, the heading 0 (the shortest rotation that takes the force to
/// nav's vertical). The measured force is f = R^T (-g) + b_a + n. With the prior of the biases, the
/// covariance is exact to first order, because f is linear in tilt and b_a. A horizontal bias is
/// not separable from tilt (theta = z x (b_a + n) / g); the norm of f determines the bias along
/// gravity. The white noise is the larger of the stated and the measured one. The window is used
/// up: the filter starts at its end.
InertialStart static_start(Time end, const StandstillMeans& means, const ImuNoise& noise,
                           const InitialiserSettings& settings);

}  // namespace chasles
