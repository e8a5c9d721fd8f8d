#pragma once

#include <variant>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/imu/body_velocity.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/overloaded.hpp>

namespace chasles {

/// The types of events, and more: a new sensor is added here. What only passes events on is
/// generic; each estimator handles every type or declines it, or does not compile.
template <typename... More>
using EventsWith = std::variant<BodyVelocity, ImuSample, FeatureFrame, More...>;

/// The data of the sensors, in order of time.
using SensorEvent = EventsWith<ImageFrame>;

/// The input of an estimator: the same, with images replaced by tracks.
using EstimatorEvent = EventsWith<>;

/// Whether an event comes from a camera. The others are samples, which are small and never dropped.
inline bool is_frame(const SensorEvent& event) {
  return std::visit(
      Overloaded{[](const FeatureFrame&) { return true; }, [](const ImageFrame&) { return true; },
                 [](const auto& /*sample*/) { return false; }},
      event);
}

}  // namespace chasles
