#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/filter/body_velocity_model.hpp>
#include <chasles/filter/stereo_measurement.hpp>
#include <chasles/slam/velocity_noise.hpp>
#include <chasles/slam/velocity_settings.hpp>

namespace chasles {

/// What the settings of a run with body velocities mean for the filter's models: the filter and the
/// batch take them from here.
BodyVelocityModel model_of(const VelocitySlamSettings& settings, const VelocitySlamNoise& noise);

/// What the model's additive states are called, in their order.
std::vector<std::string> additive_names(const BodyVelocityModel& model);

/// What is known before the first event, diagonal, of [rotation, position, additive]. With a
/// velocity state, of that nothing: the first sample says all.
Eigen::MatrixXd initial_covariance(const VelocitySlamSettings& settings,
                                   const VelocitySlamNoise& noise);

/// The noise of a sample as a measurement: that of all samples and a part of its speed.
BodyVelocityNoise sample_noise(const VelocitySlamSettings& settings, const BodyVelocityNoise& noise,
                               const BodyVelocity& u);

/// The velocity that is held over a step that ends with the sample `u`; `before` is the last one.
BodyVelocity held_velocity(const VelocitySlamSettings& settings, const BodyVelocity& before,
                           const BodyVelocity& u);

}  // namespace chasles
