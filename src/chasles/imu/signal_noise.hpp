#pragma once

#include <array>
#include <span>
#include <vector>

#include <chasles/imu/body_velocity.hpp>

namespace chasles {

/// White noise and random walk of a sampled signal, from its differences.
struct SignalNoise {
  double white = 0;  ///< of a sample [unit]
  double walk = 0;   ///< [unit/sqrt(s)]
};

/// With s1, s2 the robust deviations of first and second differences, white noise of variance R on
/// a random walk has s1^2 = 2R + q, s2^2 = 6R + 2q; the walk itself is read off at longer lags
/// (0.25, 0.5 and 1 s, the largest that stands out of the noise), where it outweighs the noise.
/// `period` is the time between samples [s]. Fewer than 4 samples tell nothing: zeros.
SignalNoise measure_signal(std::span<const double> samples, double period);

/// That of the six components, rates first, of which `velocities` are samples.
std::array<SignalNoise, 6> measure_axes(std::span<const BodyVelocity> velocities);

/// Standard deviation of a normal distribution with their median absolute value; 0 of none.
double robust_sigma(std::vector<double> values);

}  // namespace chasles
