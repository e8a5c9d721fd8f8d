#pragma once

#include <cstddef>
#include <variant>

#include <chasles/base/overloaded.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/recording/events.hpp>

namespace chasles {

/// The data of the sensors, in order of time.
using SensorEvent = EventsWith<ImageFrame>;

/// The input of an estimator: the same, with images replaced by tracks.
using EstimatorEvent = EventsWith<>;

/// Whether an event comes from a camera. The others are samples, which are small and never dropped.
template <typename... Types>
bool is_frame(const std::variant<Types...>& event) {
  constexpr std::size_t kSampleTypes = std::variant_size_v<EstimatorEvent> - 1;
  return event.index() >= kSampleTypes;
}

}  // namespace chasles
