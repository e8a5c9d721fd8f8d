#pragma once

#include <chasles/data/recording.hpp>
#include <chasles/sim/street_settings.hpp>

namespace chasles {

/// Simulates a stereo camera and a velocity sensor on a car in the streets (docs/simulation.md):
/// the very type that a reader gives, with the truth. `truth` has one pose a frame, world_T_imu,
/// the first one the identity; `true_landmarks` has the position of every landmark ever observed,
/// but of none that moves. The same settings give the same bytes. UsageError where the settings
/// cannot be driven.
Recording simulate_street(const StreetSettings& settings);

/// The rig of the settings.
StereoRig make_street_rig(const StreetSettings& settings);

}  // namespace chasles
