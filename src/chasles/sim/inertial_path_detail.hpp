#pragma once

#include <functional>

#include <chasles/lie/trajectory.hpp>
#include <chasles/sim/inertial_settings.hpp>

namespace chasles {

// What the ways of the inertial scenes have in common.

/// A place on a way in the plane, and the direction of the way [rad].
struct Step {
  Eigen::Vector2d p;
  double heading;
};

/// Poses many a knot interval: `pose` at the time on the way [s], which stands still while resting
/// and runs as the clock does after the start. `duration` [s] of the way. UsageError where there
/// would be too many.
Trajectory sample_way(const InertialSettings& settings, double duration,
                      const std::function<SE3(double)>& pose);

/// Where a turn to the right by 90 degrees has led after the part x of its way, for a turn of
/// length 1 that starts along x.
Eigen::Vector2d quarter_turn(double x);

/// The length of a walker's turn, and how far before a corner it begins [m].
double turn_length(const InertialSettings& settings);
double turn_reach(const InertialSettings& settings);

/// The walker's pose at a step of the way: he bobs, sways and turns with the time on the way [s].
SE3 with_gait(const InertialSettings& settings, const Step& step, double time);

}  // namespace chasles
