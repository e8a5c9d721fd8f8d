#pragma once

#include <limits>

#include <Eigen/Core>

#include <chasles/base/settings.hpp>
#include <chasles/base/time.hpp>

namespace chasles {

/// One sample of an inertial measurement unit, in its own axes. The accelerometer measures the
/// specific force f = R^T (a - g): at a standstill, with z up, (0, 0, +9.81).
struct ImuSample {
  Time time{};
  Eigen::Vector3d specific_force_imu = Eigen::Vector3d::Zero();  ///< [m/s^2]
  Eigen::Vector3d angular_rate_imu = Eigen::Vector3d::Zero();    ///< [rad/s]
  /// Whether the sensor was at the limit of its range. Known only of samples that a calibration has
  /// corrected, whose values no longer show it.
  bool force_clipped = false, rate_clipped = false;
};

/// The meaning of a sample. It must match the device: a mismatch acts like a bias that rotates with
/// the device (docs/derivations.md, D36).
enum class ImuConvention {
  kInstant,       ///< the value at `time`; between two samples their mean is used
  kIntervalMean,  ///< the mean since the previous sample: velocity and angle increments over the
                  ///< time
  kInstantForce,  ///< the specific force at `time`, but the mean angular rate since the previous
                  ///< sample: incremental rotations (Kleinert & Stilla, V-A)
};

constexpr bool is_force_of_instant(ImuConvention c) { return c != ImuConvention::kIntervalMean; }
constexpr bool is_rate_of_instant(ImuConvention c) { return c == ImuConvention::kInstant; }

template <>
struct Choices<ImuConvention> {
  static constexpr std::array list{Choice{ImuConvention::kInstant, "instant"},
                                   Choice{ImuConvention::kIntervalMean, "interval-mean"},
                                   Choice{ImuConvention::kInstantForce, "instant-force"}};
};

/// Continuous-time noise of an IMU, by Kalibr's names and units. A discrete sample at rate f has
/// the standard deviation density * sqrt(f); a bias grows by walk * sqrt(seconds).
struct ImuNoise {
  double accelerometer_noise_density = 0;  ///< [m/s^2/sqrt(Hz)]
  double accelerometer_random_walk = 0;    ///< [m/s^3/sqrt(Hz)]
  double gyroscope_noise_density = 0;      ///< [rad/s/sqrt(Hz)]
  double gyroscope_random_walk = 0;        ///< [rad/s^2/sqrt(Hz)]
  bool exact = false;  ///< the samples are simulated with this noise, and vibrate with no more
};

/// All four times a factor.
inline ImuNoise scaled(ImuNoise noise, double factor) {
  noise.accelerometer_noise_density *= factor;
  noise.accelerometer_random_walk *= factor;
  noise.gyroscope_noise_density *= factor;
  noise.gyroscope_random_walk *= factor;
  return noise;
}

/// Range of each sensor, per axis and sign; at or beyond it a sample is saturated.
struct ImuRange {
  double accelerometer = std::numeric_limits<double>::infinity();  ///< [m/s^2]
  double gyroscope = std::numeric_limits<double>::infinity();      ///< [rad/s]
};

/// Magnitude of standard gravity [m/s^2]; the nav frame's z axis points up.
inline constexpr double kStandardGravity = 9.80665;

}  // namespace chasles
