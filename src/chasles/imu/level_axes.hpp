#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <chasles/imu/body_velocity.hpp>

namespace chasles {

/// Level axes: z up, x where the body's x axis points to, made level. A GNSS/INS often gives its
/// velocities along such axes (KITTI's packets: "parallel to the earth's surface"), and files made
/// from them call these the body's.
struct LevelAxes {
  Eigen::Matrix3d level_R_imu;
  /// Of the turn epsilon in level axes, level_R_imu' = Exp(epsilon) level_R_imu, by the change of
  /// the vertical in the body's.
  Eigen::Matrix3d by_vertical;
};

/// `up_imu`: the vertical, of length 1. None where the body's x axis is within 3 degrees of it:
/// there is no heading then.
std::optional<LevelAxes> level_axes(const Eigen::Vector3d& up_imu);

/// Are velocities along level axes, or the body's? By as much as the body pitches up, as its rates
/// say, level ones climb (1); along its own axes it moves forward whatever it does (0, or less,
/// where springs let it pitch).
struct LevelEvidence {
  double slope = 0;  ///< climb by pitch, both from one instant to half a second later
  double sigma = 0;  ///< its standard deviation
  static constexpr double kLeastSlope = 0.2;
  bool level() const { return slope > kLeastSlope && slope > 2 * sigma; }
};

/// Of all pairs of instants at which the body moves forwards or backwards at 2 m/s or more; none
/// where there are fewer than twenty, or it never pitches.
std::optional<LevelEvidence> level_evidence(std::span<const BodyVelocity> velocities);

}  // namespace chasles
