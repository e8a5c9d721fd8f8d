#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// A motion with continuous acceleration: a uniform cubic B-spline of the positions in R^3, and of
/// the attitudes the cumulative cubic B-spline on SO(3) (Kim, Kim, Shin: "A general construction
/// scheme for unit quaternion curves", SIGGRAPH 1995).
struct Spline {
  Time start{};               ///< of the first segment
  double knot_interval = 0;   ///< [s]
  std::vector<SE3> controls;  ///< world_T_imu; one segment for every four in a row
  double duration = 0;        ///< [s], at most the number of segments times knot_interval
};

/// What an inertial sensor on the spline is moved by.
struct Motion {
  SE3 world_T_imu;
  Eigen::Vector3d v_world = Eigen::Vector3d::Zero();    ///< [m/s]
  Eigen::Vector3d a_world = Eigen::Vector3d::Zero();    ///< [m/s^2]
  Eigen::Vector3d omega_imu = Eigen::Vector3d::Zero();  ///< angular rate [rad/s]
};

/// The spline and its derivatives in closed form (Sommer et al.: "Efficient derivative computation
/// for cumulative B-splines on Lie groups", CVPR 2020), `time` seconds after its start; before the
/// start and after the end the outer segments' polynomials go on.
Motion motion_at(const Spline& spline, double time);

/// The spline nearest to the poses (world_T_imu) in the sense of least squares, which smooths what
/// is shorter than the knot interval [s]; a gap longer than that is bridged evenly, on a straight
/// line and about one axis. Between two poses, and within a knot interval, the attitude has to turn
/// by less than pi. UsageError for less than two poses, for times that do not rise, and for a
/// motion shorter than one knot interval.
Spline fit_spline(const Trajectory& poses, double knot_interval);

}  // namespace chasles
