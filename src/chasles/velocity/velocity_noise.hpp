#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/imu/body_velocity.hpp>
#include <chasles/imu/signal_noise.hpp>
#include <chasles/velocity/body_velocity_model.hpp>
#include <chasles/velocity/stereo_measurement.hpp>
#include <chasles/velocity/velocity_settings.hpp>

namespace chasles {

/// The noise of a run.
struct VelocitySlamNoise {
  BodyVelocityNoise motion;
  double gyro_bias_sigma = 0;  ///< initial [rad/s]
  StereoNoise initialisation;  ///< of an observation that initialises a landmark
  StereoNoise update;          ///< of an observation that updates one
  /// Whether the noise of updates includes errors that stay constant along a track, so that it
  /// exceeds the scatter of the observations. True where it was measured and not stated.
  bool pixels_inflated = false;
  bool level_velocities = false;  ///< along level axes (velocity/level_axes.hpp), not the IMU's
};

/// Noise that the recording itself states, where it does; taken as white.
struct StatedNoise {
  std::optional<BodyVelocitySigma> velocity;
  std::optional<Eigen::Vector4d> pixels;  ///< standard deviations of (uL, vL, uR, vR) [px]
};

/// The noise for a run: from the settings; else from the recording; else by robust differences of
/// the recording's data (docs/noise.md). The axes of the velocities are chosen likewise.
VelocitySlamNoise choose_noise(const VelocitySlamSettings& settings,
                               std::span<const BodyVelocity> velocities,
                               std::span<const FeatureFrame> frames, const StatedNoise& stated);

/// Robust standard deviation [px] of vL - vR, which is 0 without noise; at least 0.2.
double row_disagreement(std::span<const FeatureFrame> frames);

}  // namespace chasles
