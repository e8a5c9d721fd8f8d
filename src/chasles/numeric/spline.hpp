#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// A motion with continuous acceleration: a uniform cubic B-spline for the positions in R^3, and a
/// cumulative cubic B-spline on SO(3) for the attitudes (Kim, Kim, Shin: "A general construction
/// scheme for unit quaternion curves", SIGGRAPH 1995).
struct Spline {
  Time start{};               ///< of the first segment
  double knot_interval = 0;   ///< [s]
  std::vector<SE3> controls;  ///< world_T_imu; four consecutive ones define a segment
  double duration = 0;        ///< [s], at most the number of segments times knot_interval
};

/// The motion of an inertial sensor on the spline.
struct Motion {
  SE3 world_T_imu;
  Eigen::Vector3d v_world = Eigen::Vector3d::Zero();    ///< [m/s]
  Eigen::Vector3d a_world = Eigen::Vector3d::Zero();    ///< [m/s^2]
  Eigen::Vector3d omega_imu = Eigen::Vector3d::Zero();  ///< angular rate [rad/s]
};

/// The spline and its derivatives in closed form (Sommer et al.: "Efficient derivative computation
/// for cumulative B-splines on Lie groups", CVPR 2020), `time` seconds after its start; the
/// polynomials of the outer segments extend before the start and after the end.
Motion motion_at(const Spline& spline, double time);

/// The least-squares spline through the poses (world_T_imu). It smooths motion shorter than the
/// knot interval [s]. A longer gap is bridged on a straight line and about one axis. Between two
/// poses, and within a knot interval, the attitude must turn by less than pi. Throws UsageError for
/// fewer than two poses, times that do not rise, a gap of more than 1e6 knot intervals, and a
/// motion shorter than one knot interval.
Spline fit_spline(const Trajectory& poses, double knot_interval);

}  // namespace chasles
