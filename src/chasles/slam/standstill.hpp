#pragma once

#include <array>
#include <optional>
#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/filter/measurement.hpp>
#include <chasles/filter/scratch.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/slam/initialiser_settings.hpp>
#include <chasles/slam/static_conditions.hpp>
#include <chasles/slam/static_start.hpp>

namespace chasles {

/// Tells whether IMU and cameras stand still, from the last half second of both. A rest begins when
/// both say so (static_conditions, with the thresholds of a start at rest): samples that deviate as
/// their noise does, and tracks that stay where they are. It ends when one of them says otherwise;
/// where there are no tracks any more, as with a covered lens, the samples alone carry it on, as
/// long as their mean stays what it was when the rest began.
class Standstill {
 public:
  Standstill(const ImuNoise& noise, std::size_t cameras, double pixel_sigma);

  void add(const ImuSample& sample);
  /// To be called with every frame, after the samples up to it.
  bool at_rest(const FeatureFrame& frame);

 private:
  bool quiet(const RestMeans& now) const;

  ImuNoise noise_;
  std::size_t cameras_;
  double pixel_sigma_;
  InitialiserSettings thresholds_;
  std::vector<ImuSample> samples_;  ///< of the window, and those after the last frame
  Reused<FeatureFrame> frames_;     ///< of the window
  std::optional<RestMeans> began_;  ///< what the samples said when the rest began
  RestScratch scratch_;
};

/// What a rest tells: that the pose is still that of its beginning, the clone's (5 mm and 1 mrad
/// for ground that gives), and that the velocity is zero (`velocity_sigma` [m/s]). The deviations
/// are what one second of rest tells; `seconds`, since the last frame, tell their part of it.
void rest_measurements(const State& x, const Clone& began, double seconds, double velocity_sigma,
                       std::array<Measurement, 2>& result);

}  // namespace chasles
