#pragma once

#include <functional>

#include <chasles/lie/trajectory.hpp>
#include <chasles/sim/inertial_settings.hpp>

namespace chasles {

// Shared by the paths of the inertial scenes.

/// A position on a path in the plane, and the direction of the path [rad].
struct Step {
  Eigen::Vector2d p;
  double heading;
};

/// Several poses per knot interval. `pose` takes the time on the path [s], which does not advance
/// during the initial standstill and runs with the clock after the start. `duration`: of the path
/// [s]. Throws UsageError for too many poses.
Trajectory sample_way(const InertialSettings& settings, double duration,
                      const std::function<SE3(double)>& pose);

/// The position after the part x of a right turn by 90 degrees, for a turn of length 1 that starts
/// along x.
Eigen::Vector2d quarter_turn(double x);

/// The length of a walker's turn, and the distance before a corner at which it starts [m].
double turn_length(const InertialSettings& settings);
double turn_reach(const InertialSettings& settings);

/// The walker's pose at a position on the path, with bobbing, swaying and turning that depend on
/// the time on the path [s].
SE3 with_gait(const InertialSettings& settings, const Step& step, double time);

}  // namespace chasles
