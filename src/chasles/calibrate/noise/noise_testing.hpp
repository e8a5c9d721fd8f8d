#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <chasles/numeric/random.hpp>
#include <chasles/recording/recording.hpp>

// Simulated standstills, from the definitions of the noise in the time domain.
namespace chasles::test {

/// White noise on a random walk: samples with sigma N / sqrt(period), and steps with sigma
/// K sqrt(period).
inline std::vector<double> simulated_standstill(double N, double K, double period,
                                                std::size_t samples, std::uint64_t run) {
  const Random random = random_of_run(62, run);
  std::vector<double> result;
  double bias = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    result.push_back(bias + N / std::sqrt(period) * random.normal(Stream::kGyroscopeNoise, i));
    bias += K * std::sqrt(period) * random.normal(Stream::kGyroscopeWalk, i);
  }
  return result;
}

/// Flicker noise of bias instability B: white noise through half an integration (N. J. Kasdin
/// 1995), whose density is B^2 / w for small w.
inline std::vector<double> simulated_flicker(double B, std::size_t samples, std::uint64_t run) {
  const Random random = random_of_run(63, run);
  std::vector<double> weights = {1}, white, result;
  for (std::size_t i = 0; i < samples; ++i) {
    white.push_back(B * random.normal(Stream::kGyroscopeNoise, i));
    const auto k = static_cast<double>(i + 1);
    weights.push_back(weights.back() * (k - 0.5) / k);
  }
  for (std::size_t i = 0; i < samples; ++i) {
    double sum = 0;
    for (std::size_t j = 0; j <= i; ++j) sum += weights[j] * white[i - j];
    result.push_back(sum);
  }
  return result;
}

/// A recording of an IMU alone that lies level, with white noise and walks on all axes.
inline Recording standstill_recording(double seconds, double rate, const ImuNoise& noise,
                                      std::uint64_t run) {
  Recording recording;
  recording.name = "standstill";
  const auto count = static_cast<std::size_t>(seconds * rate);
  recording.imu.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    recording.imu[i].time = from_seconds(static_cast<double>(i) / rate);
  }
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto of_axis = static_cast<std::uint64_t>(axis);
    const auto force =
        simulated_standstill(noise.accelerometer_noise_density, noise.accelerometer_random_walk,
                             1 / rate, count, 6 * run + of_axis);
    const auto angular =
        simulated_standstill(noise.gyroscope_noise_density, noise.gyroscope_random_walk, 1 / rate,
                             count, 6 * run + 3 + of_axis);
    for (std::size_t i = 0; i < count; ++i) {
      recording.imu[i].specific_force_imu[axis] = force[i] + (axis == 2 ? kStandardGravity : 0);
      recording.imu[i].angular_rate_imu[axis] = angular[i] + 0.01;
    }
  }
  return recording;
}

/// Adds a motion by hand, below 5 Hz, between these times [s].
inline void add_motion(Recording& recording, double from, double to) {
  for (ImuSample& sample : recording.imu) {
    const double time = to_seconds(sample.time - recording.imu.front().time);
    if (time < from || time >= to) continue;
    for (const double frequency : {0.7, 1.9, 4.3}) {
      const double swing = std::sin(2 * std::numbers::pi * frequency * time);
      sample.specific_force_imu += swing * Eigen::Vector3d(0.6, -1, 0.8);
      sample.angular_rate_imu += swing * Eigen::Vector3d(-0.5, 0.3, 0.7);
    }
  }
}

/// That of a sensor of robots.
inline constexpr ImuNoise kSensorNoise{.accelerometer_noise_density = 2e-3,
                                       .accelerometer_random_walk = 3e-4,
                                       .gyroscope_noise_density = 1.7e-4,
                                       .gyroscope_random_walk = 2e-5};

}  // namespace chasles::test
