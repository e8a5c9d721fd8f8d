#pragma once

#include <variant>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/imu/body_velocity.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// The types of events: samples, then frames of tracks, then further frames. A new sensor is added
/// here, before FeatureFrame. Code that only passes events on is generic; each estimator handles
/// every type or ignores it by name, or does not compile.
template <typename... MoreFrames>
using EventsWith = std::variant<BodyVelocity, ImuSample, FeatureFrame, MoreFrames...>;

}  // namespace chasles
