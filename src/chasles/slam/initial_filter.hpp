#pragma once

#include <span>

#include <chasles/filter/ekf.hpp>
#include <chasles/initialise/inertial_start.hpp>
#include <chasles/slam/inertial_settings.hpp>

namespace chasles {

/// The filter with its state at the start: pose, velocity, biases, and what of the calibration is
/// estimated.
Ekf initial_filter(const InertialSlamSettings& settings, const InertialStart& start,
                   std::span<const Camera> cameras);

/// Whether past landmarks are in the nav axes of the filter (Ekf::Map::kPast).
bool keeps_past(const InertialSlamSettings& settings);

}  // namespace chasles
