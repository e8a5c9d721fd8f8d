#pragma once

#include <vector>

#include <chasles/data/recording.hpp>
#include <chasles/sim/inertial_settings.hpp>
#include <chasles/sim/spline.hpp>

namespace chasles {

/// What an ideal IMU measures on the spline, at `rate` [Hz] from its start on, as many samples as
/// its duration holds.
///
/// kInstant: f = R^T (a - g) and the angular rate, of the instant. kIntervalMean: with R, v at the
/// sample before and R+, v+ at the sample, w = Log(R^T R+) / tau and f = Jl(w tau)^-1 R^T
/// (v+ - v - g tau) / tau, so that `integrate` (strapdown.hpp) reproduces attitude and velocity to
/// round-off; the first sample, which has none before it, is of the instant.
std::vector<ImuSample> ideal_imu(const Spline& motion, double rate, ImuConvention convention);

/// Simulated samples, and at the time of each one the true velocity and the biases it contains.
struct SimulatedImu {
  std::vector<ImuSample> samples;
  std::vector<TrueMotion> truth;
};

/// The ideal samples with biases, which begin at a normal draw and walk at random, and white noise
/// of density * sqrt(rate); all of them depend on the settings' seed and the run.
SimulatedImu simulate_imu(const InertialSettings& settings, const Spline& motion,
                          std::uint64_t run);

/// The densities that the settings state.
ImuNoise imu_noise(const InertialSettings& settings);

}  // namespace chasles
