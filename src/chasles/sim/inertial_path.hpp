#pragma once

#include <chasles/lie/trajectory.hpp>
#include <chasles/sim/inertial_settings.hpp>

namespace chasles {

/// An axis-parallel box in the world frame [m].
struct Box {
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  Eigen::Vector3d high = Eigen::Vector3d::Zero();
};

/// A corridor around a block: what lies inside `outer` and outside `inner`. The walk starts above
/// the origin, behind the corner of the centre line, along x.
struct Hallway {
  Box outer, inner;
};

/// UsageError where a section is too short for its turns.
Hallway make_hallway(const InertialSettings& settings);

/// The poses world_T_imu of a walker in the hallway, many a knot interval, from rest or at once at
/// full speed; z up, z = 0 at the IMU's mean height. The walker bobs and sways with the steps and
/// turns right by 90 degrees after every section. UsageError where the way would touch a wall.
Trajectory hallway_path(const InertialSettings& settings);

/// The poses world_T_imu on a circle around the cube at the origin, with some sway (a uniform
/// circle makes scale look like an accelerometer bias, docs/derivations.md, D58); the IMU's x axis
/// points at the cube's centre but for `gaze_sway`.
Trajectory turntable_path(const InertialSettings& settings);

}  // namespace chasles
