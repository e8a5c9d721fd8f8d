#pragma once

#include <array>
#include <span>
#include <vector>

#include <chasles/imu/body_velocity.hpp>

namespace chasles {

/// White noise and random walk of a sampled signal, estimated from its differences.
struct SignalNoise {
  double white = 0;  ///< standard deviation of a sample [unit]
  double walk = 0;   ///< [unit/sqrt(s)]
};

/// Let s1, s2 be the robust standard deviations of first and second differences. White noise of
/// variance R on a random walk gives s1^2 = 2R + q, s2^2 = 6R + 2q. The walk is estimated at longer
/// lags (0.25, 0.5 and 1 s, the largest value that exceeds the noise), where it dominates. `period`
/// is the time between samples [s]. Returns zeros for fewer than 4 samples.
SignalNoise measure_signal(std::span<const double> samples, double period);

/// The noise of the six components of the body velocities, angular rates first [rad/s, m/s].
std::array<SignalNoise, 6> measure_axes(std::span<const BodyVelocity> velocities);

/// Standard deviation of a zero-mean normal distribution with the same median absolute value; 0 for
/// an empty list.
double robust_sigma(std::vector<double> values);

}  // namespace chasles
