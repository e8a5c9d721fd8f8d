#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <chasles/imu/body_velocity.hpp>

namespace chasles {

/// Level axes: z up, x along the horizontal projection of the body's x axis. A GNSS/INS often
/// reports its velocities in these axes (KITTI's packets: "parallel to the earth's surface"). Files
/// converted from it may label them as body velocities.
struct LevelAxes {
  Eigen::Matrix3d level_R_imu;
  /// d epsilon / d (vertical in body axes), where level_R_imu' = Exp(epsilon) level_R_imu and
  /// epsilon is in level axes [rad].
  Eigen::Matrix3d by_vertical;
};

/// `up_imu`: the vertical in IMU axes, of unit length. None if the body's x axis is within 3
/// degrees of the vertical: the heading is undefined there.
std::optional<LevelAxes> level_axes(const Eigen::Vector3d& up_imu);

/// Evidence whether velocities are in level axes or in body axes. In level axes the climb angle of
/// the velocity follows the pitch from the angular rates (slope 1). In body axes the velocity stays
/// along x (slope 0, or less where the suspension pitches).
struct LevelEvidence {
  double slope = 0;  ///< change of climb angle per change of pitch, over half a second
  double sigma = 0;  ///< its standard deviation
  static constexpr double kLeastSlope = 0.2;
  bool level() const { return slope > kLeastSlope && slope > 2 * sigma; }
};

/// Uses all pairs of instants with a forward or backward speed of 2 m/s or more. None with fewer
/// than twenty pairs, or without pitch motion.
std::optional<LevelEvidence> level_evidence(std::span<const BodyVelocity> velocities);

}  // namespace chasles
