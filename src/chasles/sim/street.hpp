#pragma once

#include <chasles/recording/recording.hpp>
#include <chasles/sim/street_settings.hpp>

namespace chasles {

/// Simulates a stereo camera and a velocity sensor on a car in the streets (docs/simulation.md).
/// The result has the type that a reader returns, with the truth. `truth` has one pose per frame,
/// world_T_imu, the first one the identity. `true_landmarks` has the position of every static
/// landmark ever observed. The same settings give the same bytes. Throws UsageError if the car
/// cannot follow the settings.
Recording simulate_street(const StreetSettings& settings);

/// The rig of the settings.
StereoRig make_street_rig(const StreetSettings& settings);

}  // namespace chasles
