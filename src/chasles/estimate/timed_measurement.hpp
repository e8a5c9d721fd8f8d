#pragma once

#include <functional>

#include <chasles/base/time.hpp>
#include <chasles/filter/measurement.hpp>
#include <chasles/filter/state.hpp>

namespace chasles {

/// A measurement by a sensor that the filter does not know: a barometer, a compass, a wheel. It
/// measures the core state (pose, velocity, biases), and no landmark. A new sensor needs its
/// measurement model and one call of InertialSession::process().
struct TimedMeasurement {
  Time time{};  ///< by the IMU's clock
  /// The measurement, linearised at the state of that time (docs/filter.md, section 2). Where it
  /// sets no gate of its own, the filter's gate applies. What it throws passes through.
  std::function<Measurement(const State&)> model;
};

/// What became of them.
struct TimedMeasurementCounts {
  int used = 0;
  int rejected = 0;  ///< by the gate, or not finite
  int late = 0;      ///< dropped: before the start, older than the state, or lost with it
};

}  // namespace chasles
