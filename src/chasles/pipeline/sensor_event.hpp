#pragma once

#include <variant>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/imu/body_velocity.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/overloaded.hpp>

namespace chasles {

/// What sensors deliver, in the order of time.
using SensorEvent = std::variant<BodyVelocity, ImuSample, FeatureFrame, ImageFrame>;

/// What an estimator takes: the same, with images tracked.
using EstimatorEvent = std::variant<BodyVelocity, ImuSample, FeatureFrame>;

/// Whether an event is of a camera. The others are samples, which are small and never dropped.
inline bool is_frame(const SensorEvent& event) {
  return std::visit(
      Overloaded{[](const BodyVelocity&) { return false; }, [](const ImuSample&) { return false; },
                 [](const FeatureFrame&) { return true; }, [](const ImageFrame&) { return true; }},
      event);
}

}  // namespace chasles
