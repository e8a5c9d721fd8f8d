#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <chasles/imu/signal_noise.hpp>
#include <chasles/velocity/level_axes.hpp>
#include <chasles/velocity/velocity_noise.hpp>

namespace chasles {
namespace {

// Errors that the differences do not contain, because they hardly change from sample to sample
// (latency, mounting, the filter of the GNSS/INS behind the data). Chosen over all available
// recordings (docs/noise.md).
constexpr double kRateFloor = 0.0005;         // [rad/s]
constexpr double kVelocityFloor = 0.1;        // [m/s]
constexpr double kRateWalkFloor = 0.025;      // [rad/s/sqrt(s)]
constexpr double kVelocityWalkFloor = 0.013;  // [m/s/sqrt(s)]
constexpr double kRateWalkPerSigma = 2;       // [1/sqrt(s)]: a noisy gyroscope hides true changes
// Corrections of the walks estimated from the signal: rotation is smoother than its structure
// function (it turns in corners only), translation rougher (brakes and gears).
constexpr double kRateWalkFactor = 0.9;
constexpr double kVelocityWalkFactor = 1.7;
// The assumed bias of a gyroscope, as a fraction of its white noise.
constexpr double kBiasPerSigma = 0.02;
constexpr double kBiasWalkPerSigma = 0.005;  // [1/sqrt(s)]
// vL - vR contains the noise of one instant. The error of a track also drifts and stays (KLT,
// moving objects).
constexpr double kPixelPerRowNoise = 5.5;
constexpr double kDisparityPerRowNoise = 1.1;
constexpr double kDisparityInflation = 4;
constexpr double kSmallestRowNoise = 0.2;  // [px]

// The set value for all axes; otherwise the axes keep their own.
void set_axes(const std::optional<double>& value, Eigen::Ref<Eigen::Vector3d> axes) {
  if (value) axes.setConstant(*value);
}

BodyVelocityNoise motion_noise(const VelocitySlamSettings& settings,
                               std::span<const BodyVelocity> velocities,
                               const StatedNoise& stated) {
  const std::array<SignalNoise, 6> measured = measure_axes(velocities);
  BodyVelocityNoise noise;
  for (Eigen::Index i = 0; i < 6; ++i) {
    const SignalNoise& signal = measured[static_cast<std::size_t>(i)];
    const double white = std::hypot(signal.white, i < 3 ? kRateFloor : kVelocityFloor);
    noise.sample_sigma[i] = white;
    noise.walk[i] =
        i < 3 ? std::max({kRateWalkFactor * signal.walk, kRateWalkFloor, kRateWalkPerSigma * white})
              : std::max(kVelocityWalkFactor * signal.walk, kVelocityWalkFloor);
  }
  if (stated.velocity) noise.sample_sigma << stated.velocity->angular, stated.velocity->linear;
  set_axes(settings.rate_sigma, noise.sample_sigma.head<3>());
  set_axes(settings.velocity_sigma, noise.sample_sigma.tail<3>());
  set_axes(settings.rate_walk, noise.walk.head<3>());
  set_axes(settings.velocity_walk, noise.walk.tail<3>());
  noise.gyro_bias_walk =
      settings.gyro_bias_walk.value_or(kBiasWalkPerSigma * noise.sample_sigma.head<3>().maxCoeff());
  noise.scale_walk = settings.velocity_scale_walk;
  noise.tilt_walk = settings.tilt_walk;
  noise.heading_walk = settings.velocity_heading_walk;
  return noise;
}

StereoNoise initialisation_noise(const VelocitySlamSettings& settings,
                                 std::span<const FeatureFrame> frames, const StatedNoise& stated) {
  StereoNoise noise;
  if (stated.pixels) {
    const Eigen::Vector4d& s = *stated.pixels;
    noise.u = std::hypot(s[0], s[2]) / 2;
    noise.v = std::hypot(s[1], s[3]) / 2;
    noise.disparity = std::hypot(s[0], s[2]);
  } else {
    const double row_noise = row_disagreement(frames);
    noise.u = noise.v = kPixelPerRowNoise * row_noise;
    noise.disparity = kDisparityPerRowNoise * row_noise;
  }
  noise.u = settings.pixel_sigma.value_or(noise.u);
  noise.v = settings.pixel_sigma.value_or(noise.v);
  noise.disparity = settings.disparity_sigma.value_or(noise.disparity);
  return noise;
}

bool are_level(const VelocitySlamSettings& settings, std::span<const BodyVelocity> velocities) {
  if (settings.velocity_axes != VelocityAxes::kAuto) {
    return settings.velocity_axes == VelocityAxes::kLevel;
  }
  const std::optional<LevelEvidence> evidence = level_evidence(velocities);
  return evidence && evidence->level();
}

}  // namespace

double row_disagreement(std::span<const FeatureFrame> frames) {
  std::vector<double> rows;
  for (const FeatureFrame& frame : frames) {
    for (const StereoObservation& o : frame.observations) {
      rows.push_back(o.pixels[1] - o.pixels[3]);
    }
  }
  if (rows.empty()) return kSmallestRowNoise;
  const auto middle = rows.begin() + static_cast<std::ptrdiff_t>(rows.size() / 2);
  std::nth_element(rows.begin(), middle, rows.end());
  const double median = *middle;  // a calibration's constant error is not noise
  for (double& row : rows) row -= median;
  return std::max(kSmallestRowNoise, robust_sigma(std::move(rows)));
}

VelocitySlamNoise choose_noise(const VelocitySlamSettings& settings,
                               std::span<const BodyVelocity> velocities,
                               std::span<const FeatureFrame> frames, const StatedNoise& stated) {
  VelocitySlamNoise noise;
  noise.motion = motion_noise(settings, velocities, stated);
  noise.pixels_inflated = !stated.pixels && !settings.pixel_sigma;
  noise.level_velocities = are_level(settings, velocities);
  noise.gyro_bias_sigma = settings.gyro_bias_sigma.value_or(
      kBiasPerSigma * noise.motion.sample_sigma.head<3>().maxCoeff());
  noise.initialisation = initialisation_noise(settings, frames, stated);
  noise.update = noise.initialisation;
  noise.update.disparity *=
      settings.disparity_inflation.value_or(stated.pixels ? 1 : kDisparityInflation);
  return noise;
}

}  // namespace chasles
