#pragma once

#include <array>
#include <optional>

#include <chasles/initialise/standstill.hpp>
#include <chasles/slam/slam_context.hpp>

namespace chasles {

/// Zero-velocity updates: during a standstill, the pose is that of the clone at its beginning and
/// the velocity is zero.
class ZeroVelocityUpdater {
 public:
  /// The noise of the IMU as stated. Nothing is detected with zupt_velocity_sigma = 0.
  ZeroVelocityUpdater(const InertialSlamSettings& settings, const ImuNoise& noise,
                      std::size_t cameras, double pixel_sigma);

  /// A sample that is a measurement.
  void add(const ImuSample& sample) {
    if (standstill_) standstill_->add(sample);
  }
  /// Whether an update was made. `since`: the time since the last frame.
  bool update(SlamContext& x, const FeatureFrame& frame, Time since);
  /// The clone that the standstill refers to.
  std::optional<int> clone() const { return clone_; }

 private:
  std::optional<Standstill> standstill_;
  std::optional<int> clone_;
  std::array<Measurement, 2> measurements_;
};

}  // namespace chasles
