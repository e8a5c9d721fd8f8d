#pragma once

#include <optional>
#include <string>

#include <chasles/estimate/estimate.hpp>
#include <chasles/initialise/inertial_start.hpp>
#include <chasles/recording/recording.hpp>

// A recording's ground truth, for runs that start from it or are compared with it.
namespace chasles {

/// The true pose world_T_imu at that time, as pose_at() with the recording's longest gap.
std::optional<SE3> true_pose_at(const Recording& recording, Time time);

/// Velocity and biases at that time: of that stamp, or on a straight line between two that are at
/// most the recording's longest gap apart; none elsewhere.
std::optional<TrueMotion> true_motion_at(const Recording& recording, Time time);

/// The truth at the first frame that has one; biases are 0. The true velocity is the recording's,
/// or the slope of its true positions. The covariance is absent: the settings' initial sigmas.
/// Throws InputError where there is no truth.
InertialStart true_start(const Recording& recording);

/// The NEES of pose, velocity and biases together, in the coordinates of the filter's chart
/// [expected: 15]. NaN where the recording has no true velocity and biases at that time, or where
/// the covariance is singular.
double state_nees(const std::string& chart, const Recording& recording, const Estimate& estimate);

}  // namespace chasles
