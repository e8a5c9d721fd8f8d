#pragma once

#include <chasles/lie/trajectory.hpp>
#include <chasles/sim/inertial_settings.hpp>

namespace chasles {

/// An axis-parallel box in the world frame [m].
struct Box {
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  Eigen::Vector3d high = Eigen::Vector3d::Zero();
};

/// A corridor around a block: the space inside `outer` and outside `inner`. The walk starts above
/// the origin, after a corner of the centre line, along x.
struct Hallway {
  Box outer, inner;
};

/// Throws UsageError if a section is too short for its turns.
Hallway make_hallway(const InertialSettings& settings);

/// The poses world_T_imu of a walker in the hallway, several per knot interval, from a standstill
/// or at full speed from the start; z up, z = 0 at the IMU's mean height. The walker bobs and sways
/// with the steps and turns right by 90 degrees after every section. Throws UsageError if the path
/// would touch a wall.
Trajectory hallway_path(const InertialSettings& settings);

/// The poses world_T_imu on a circle around the cube at the origin, with some sway: on a uniform
/// circle scale and accelerometer bias are not separable (docs/derivations.md, D58). The IMU's x
/// axis points at the cube's centre except for `gaze_sway`.
Trajectory turntable_path(const InertialSettings& settings);

}  // namespace chasles
