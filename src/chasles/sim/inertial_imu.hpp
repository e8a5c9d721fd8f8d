#pragma once

#include <vector>

#include <chasles/numeric/spline.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/sim/inertial_settings.hpp>

namespace chasles {

/// The measurements of an ideal IMU on the spline, at `rate` [Hz] from its start on, as many
/// samples as fit into its duration.
///
/// kInstant: f = R^T (a - g) and the angular rate at the instant. kIntervalMean: with R, v at the
/// sample before and R+, v+ at the sample, w = Log(R^T R+) / tau and f = Jl(w tau)^-1 R^T (v+ - v -
/// g tau) / tau, so that `integrate` (strapdown.hpp) reproduces attitude and velocity to round-off.
/// kInstantForce: the f of the former and the w of the latter. The first sample, which has no
/// predecessor, is that of the instant.
std::vector<ImuSample> ideal_imu(const Spline& motion, double rate, ImuConvention convention);

/// Simulated samples, and for each one the true velocity and the biases that it contains.
struct SimulatedImu {
  std::vector<ImuSample> samples;
  std::vector<TrueMotion> truth;
};

/// The ideal samples with biases and white noise. The biases start at a normal draw and follow a
/// random walk; the noise has sigma density * sqrt(rate). All depend on the settings' seed and the
/// run.
SimulatedImu simulate_imu(const InertialSettings& settings, const Spline& motion,
                          std::uint64_t run);

/// The noise densities that the settings define.
ImuNoise imu_noise(const InertialSettings& settings);

}  // namespace chasles
