#pragma once

#include <vector>

#include <chasles/calibrate/inertial_problem_detail.hpp>
#include <chasles/calibrate/rotation_alignment.hpp>

/// Where the search of a calibration with an IMU begins. Private to the calibrate folder.
namespace chasles::calibrate_detail {

/// The first camera's rotations against the gyroscope. Throws InputError where they do not agree.
RotationAlignment aligned(const InertialCalibrationInput& input, const CamerasCalibration& alone);

/// The views whose lines the IMU covers, by instants of the IMU's clock; they point into `views`.
/// `offset`: camera clock + offset = IMU clock [s].
std::vector<InertialInstant> inertial_instants(const std::vector<ExplainedView>& views,
                                               const InertialCalibrationInput& input,
                                               double offset);

/// Poses by the cameras, velocities by their differences, gravity by the mean force. Throws
/// InputError for forces that do not belong to this motion.
InertialRig first_rig(const InertialCalibrationInput& input, const CamerasCalibration& alone,
                      const RotationAlignment& alignment,
                      const std::vector<InertialInstant>& instants);

}  // namespace chasles::calibrate_detail
