#pragma once

#include <span>

#include <chasles/slam/inertial_session.hpp>

#include "inertial_drive.hpp"

// How a run with an IMU begins, and what is kept of an estimate.
namespace chasles::app {

/// What is known before the first event. Throws InputError where the IMU's noise is missing.
InertialDrive prepared(const Recording& recording, const InertialRunSettings& settings,
                       const InertialDriveOptions& options);

/// As the filter takes them: what is "auto" may depend on the recording.
InertialSlamSettings filter_settings(const Recording& recording,
                                     const InertialRunSettings& settings);

/// With the recording's noise, which `result` has. Throws Error(kNotInitialised) where it is to
/// begin at a truth that is not there.
InertialSession session_for(const Recording& recording, const InertialRunSettings& settings,
                            const InertialDrive& result, bool from_truth);

ImuBuffer::Options imu_options(const Recording& recording);

/// `milliseconds`: that the frame took, or how late it came.
RunState run_state(const InertialEstimate& e, std::span<const Camera> cameras, double milliseconds);

}  // namespace chasles::app
