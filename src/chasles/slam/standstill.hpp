#pragma once

#include <deque>
#include <optional>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/slam/initialiser_settings.hpp>
#include <chasles/slam/rest_start.hpp>

namespace chasles {

/// Tells whether IMU and cameras stand still, from the last half second of both. A rest begins when
/// both say so (rest_conditions, with the thresholds of a start at rest): samples that deviate as
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
  std::deque<ImuSample> samples_;
  std::deque<FeatureFrame> frames_;
  std::optional<RestMeans> began_;  ///< what the samples said when the rest began
};

}  // namespace chasles
