#pragma once

#include <optional>
#include <span>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/filter/body_velocity_model.hpp>
#include <chasles/filter/stereo_measurement.hpp>
#include <chasles/imu/body_velocity.hpp>
#include <chasles/slam/settings.hpp>

namespace chasles {

/// The noise that a run works with.
struct Noise {
  BodyVelocityNoise motion;
  StereoNoise stereo;
  double gyro_bias_sigma = 0;  ///< initial [rad/s]
};

/// What a recording's own file says of its noise (standard deviations); the readers fill it in.
struct StatedNoise {
  Vector6d velocity_sigma = Vector6d::Zero();     ///< of a sample [angular rad/s; linear m/s]
  Eigen::Vector4d pixel_sigma = Eigen::Vector4d::Zero();  ///< of (uL, vL, uR, vR) [px]
};

/// The noise for a run: what the settings say; else what the recording states; else what is measured
/// from the recording itself by robust differences (docs/noise.md).
Noise choose_noise(const Settings& settings, std::span<const BodyVelocity> velocities,
                   std::span<const FeatureFrame> frames,
                   const std::optional<StatedNoise>& stated);

}  // namespace chasles
