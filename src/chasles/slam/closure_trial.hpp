#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <chasles/slam/inertial_slam.hpp>

namespace chasles {

/// Whether landmarks that have returned agree with the frames after. A wrong match that got through
/// all tests shows when the camera has moved: the gate rejects its landmark for good. Where it
/// rejects most of those that returned, within two seconds, the filter becomes what it would be if
/// they had not: a copy of it from before the closure, and the frames and samples since then.
class ClosureTrial {
 public:
  /// What the filter takes, for the copy.
  void process(const ImuSample& sample) {
    if (without_) without_->process(sample);
  }
  void process(const TimedMeasurement& measurement) {
    if (without_) without_->process(measurement);
  }
  /// After each frame of the filter: the estimate of the other one, if it has replaced the filter.
  std::optional<Estimate> assess(const FeatureFrame& frame, std::unique_ptr<InertialSlam>& slam);
  void end();

 private:
  Estimate undo(std::unique_ptr<InertialSlam>& slam);

  std::shared_ptr<InertialSlam> without_;
  std::vector<FeatureFrame> frames_;  ///< since the first of the closures
  std::vector<LandmarkId> returned_;
  std::size_t rejected_ = 0;  ///< of them
  std::size_t closures_before_ = 0;
  Time until_{};
};

}  // namespace chasles
