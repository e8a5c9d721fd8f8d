#pragma once

#include <cstdint>
#include <vector>

#include <chasles/camera/image_frame.hpp>
#include <chasles/sim/inertial_settings.hpp>

namespace chasles {

/// Converts light to images like a sensor: varying exposure, vignetting, noise with variance
/// readout_noise^2 + photon_noise * brightness, 256 shades.
class RenderSensor {
 public:
  RenderSensor(const InertialSettings& settings, std::uint64_t run);

  /// The exposure factor at a time since the start [s]: exposure * 2^(exposure_drift * w), w in
  /// [-1, 1].
  double exposure_at(double time) const;

  /// `light`: width * height shades. The noise depends on seed, run, frame and camera only.
  GrayImage expose(const std::vector<float>& light, int width, int height, double time,
                   std::uint32_t frame, std::uint32_t camera) const;

 private:
  InertialSettings settings_;
  std::uint64_t key_;
  std::vector<float> normals_;  ///< quantiles of the normal distribution
  double phases_[2];
};

}  // namespace chasles
