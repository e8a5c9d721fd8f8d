#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/filter/body_velocity_model.hpp>
#include <chasles/filter/stereo_measurement.hpp>
#include <chasles/imu/body_velocity.hpp>
#include <chasles/imu/signal_noise.hpp>
#include <chasles/slam/velocity_settings.hpp>

namespace chasles {

/// The noise that a run works with.
struct VelocitySlamNoise {
  BodyVelocityNoise motion;
  double gyro_bias_sigma = 0;  ///< initial [rad/s]
  StereoNoise begin;           ///< of an observation that begins a landmark
  StereoNoise update;          ///< of one that updates it
  /// That of updates stands for errors that stay along a track, and is larger than what looks
  /// scatter by: it was measured, not stated.
  bool pixels_inflated = false;
  bool level_velocities = false;  ///< along level axes (imu/level_axes.hpp), not the IMU's
};

/// What a recording itself states of its noise, where it does; taken as white.
struct StatedNoise {
  std::optional<BodyVelocitySigma> velocity;
  std::optional<Eigen::Vector4d> pixels;  ///< standard deviations of (uL, vL, uR, vR) [px]
};

/// The noise for a run: what the settings say; else what the recording states; else what robust
/// differences of the recording's own numbers tell (docs/noise.md). So it is with the axes of the
/// velocities.
VelocitySlamNoise choose_noise(const VelocitySlamSettings& settings,
                               std::span<const BodyVelocity> velocities,
                               std::span<const FeatureFrame> frames, const StatedNoise& stated);

/// Robust deviation [px] of vL - vR, which would be 0 without noise; at least 0.2.
double row_disagreement(std::span<const FeatureFrame> frames);

}  // namespace chasles
