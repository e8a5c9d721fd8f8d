#pragma once

#include <deque>
#include <span>
#include <vector>

#include <chasles/filter/calibration.hpp>
#include <chasles/slam/inertial_settings.hpp>
#include <chasles/slam/inertial_start.hpp>

namespace chasles {

/// What of the sensors' arrangement the settings have estimated, as it is before anything was seen:
/// the cameras' own places and the settings' time offset, with the deviations of the settings. None
/// where nothing is estimated.
std::optional<Calibration> stated_calibration(const InertialSlamSettings& settings,
                                              std::span<const Camera> cameras);

/// The cameras with what has been learnt of their places.
std::vector<Camera> calibrated(std::vector<Camera> cameras,
                               const std::optional<Calibration>& calibration);

/// A start that was found in motion with a calibration that is wrong is wrong by more than it says.
/// Images that come `s` seconds late look turned and moved by s times the rates of turn and
/// acceleration against the samples of the same stamp; what the rates vary by within the window
/// goes into tilt, velocity and, over the window's length, biases. Cameras turned by an angle turn
/// the velocity. These, for the deviations of time offset and rotations, are added to the start's
/// covariance; nothing at rest. `samples`: those that the start was found with, in order of time.
void widen_start(const Calibration& calibration, const std::deque<ImuSample>& samples,
                 InertialStart& start);

}  // namespace chasles
