#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/lie/se3.hpp>
#include <chasles/sim/street_path.hpp>
#include <chasles/sim/street_settings.hpp>

namespace chasles {

/// The road's height above its mean: a sinusoid in x and one in y; 0 at the origin.
struct Road {
  double amplitude = 0;   ///< [m]
  double wavelength = 1;  ///< along x; along y it is 1.31 times as long [m]

  double height(const Eigen::Vector2d& p) const;
  Eigen::Vector2d gradient(const Eigen::Vector2d& p) const;
};

/// An interval in which the speed changes from one value to another, by a smoothstep.
struct SpeedPiece {
  double start_time = 0;  ///< [s]
  double duration = 0;    ///< [s]
  double start_way = 0;   ///< [m]
  double from = 0;        ///< [m/s]
  double to = 0;          ///< [m/s]
};

/// The motion of the car as a function of time.
struct StreetDrive {
  StreetPath path;
  std::vector<SpeedPiece> speeds;
  Road road;
  double roll_amplitude = 0, pitch_amplitude = 0, sway_wavelength = 1;
  double duration = 0;  ///< [s]
};

/// The pose and velocities of the car. The velocities are the exact derivative of the pose.
struct DriveState {
  SE3 world_T_imu;              ///< x forward, y left, z up; the identity at time 0
  Eigen::Vector3d linear_imu;   ///< [m/s]
  Eigen::Vector3d angular_imu;  ///< [rad/s]
  double heading = 0;           ///< [rad]
};

/// Throws UsageError if a street is too short to accelerate and brake.
StreetDrive make_street_drive(const StreetSettings& settings);

/// The state at a time [s], 0 <= time <= drive.duration.
DriveState state_at(const StreetDrive& drive, double time);

}  // namespace chasles
