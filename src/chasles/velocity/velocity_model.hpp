#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/velocity/body_velocity_model.hpp>
#include <chasles/velocity/stereo_measurement.hpp>
#include <chasles/velocity/velocity_noise.hpp>
#include <chasles/velocity/velocity_settings.hpp>

namespace chasles {

/// The filter model for the settings of a stereo-velocity run, for the filter and for the batch.
BodyVelocityModel model_of(const VelocitySlamSettings& settings, const VelocitySlamNoise& noise);

/// The names of the model's additive states, in order.
std::vector<std::string> additive_names(const BodyVelocityModel& model);

/// Diagonal covariance of [rotation, position, additive] before the first event. A velocity state
/// is unknown; the first sample determines it.
Eigen::MatrixXd initial_covariance(const VelocitySlamSettings& settings,
                                   const VelocitySlamNoise& noise);

/// The noise of a sample as a measurement: the common noise plus a fraction of its speed.
BodyVelocityNoise sample_noise(const VelocitySlamSettings& settings, const BodyVelocityNoise& noise,
                               const BodyVelocity& u);

/// The velocity that is held over a step that ends with the sample `u`; `before` is the previous
/// one.
BodyVelocity held_velocity(const VelocitySlamSettings& settings, const BodyVelocity& before,
                           const BodyVelocity& u);

}  // namespace chasles
