#pragma once

#include <variant>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/imu/body_velocity.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/overloaded.hpp>

namespace chasles {

/// The data of the sensors, in order of time.
using SensorEvent = std::variant<BodyVelocity, ImuSample, FeatureFrame, ImageFrame>;

/// The input of an estimator: the same, with images replaced by tracks.
using EstimatorEvent = std::variant<BodyVelocity, ImuSample, FeatureFrame>;

/// Whether an event comes from a camera. The others are samples, which are small and never dropped.
inline bool is_frame(const SensorEvent& event) {
  return std::visit(
      Overloaded{[](const BodyVelocity&) { return false; }, [](const ImuSample&) { return false; },
                 [](const FeatureFrame&) { return true; }, [](const ImageFrame&) { return true; }},
      event);
}

}  // namespace chasles
