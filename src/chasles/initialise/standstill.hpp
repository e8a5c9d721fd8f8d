#pragma once

#include <array>
#include <optional>
#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/filter/measurement.hpp>
#include <chasles/filter/scratch.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/initialise/initialiser_settings.hpp>
#include <chasles/initialise/static_conditions.hpp>
#include <chasles/initialise/static_start.hpp>

namespace chasles {

/// Detects a standstill of IMU and cameras from their last half second. A standstill begins when
/// both show no motion (static_conditions, with the thresholds of the static initialisation): the
/// scatter of the samples matches their noise, and the tracks keep their pixels. It ends when one
/// of them shows motion. Without tracks, as with a covered lens, the samples alone extend it as
/// long as their mean equals that at its beginning.
class Standstill {
 public:
  Standstill(const ImuNoise& noise, std::size_t cameras, double pixel_sigma);

  /// Finite samples, with times that rise.
  void add(const ImuSample& sample);
  /// Whether there is a standstill at this frame. Call it for every frame, after the samples up to
  /// it.
  bool detected(const FeatureFrame& frame);

 private:
  bool quiet(const StandstillMeans& now) const;

  ImuNoise noise_;
  std::size_t cameras_;
  double pixel_sigma_;
  InitialiserSettings thresholds_;
  std::vector<ImuSample> samples_;  ///< of the window, and those after the last frame
  Reused<FeatureFrame> frames_;     ///< of the window
  std::optional<StandstillMeans>
      start_;  ///< means of the samples at the beginning of the standstill
  StandstillScratch scratch_;
};

/// The two measurements of a zero-velocity update. The pose is still that of the clone at the
/// beginning of the standstill (5 mm and 1 mrad, because the ground may yield). The velocity is
/// zero (`velocity_sigma` [m/s]). These sigmas are for one second of standstill; the noise is
/// scaled to `seconds`, the time since the last frame.
void zero_velocity_measurements(const State& x, const Clone& start, double seconds,
                                double velocity_sigma, std::array<Measurement, 2>& result);

}  // namespace chasles
