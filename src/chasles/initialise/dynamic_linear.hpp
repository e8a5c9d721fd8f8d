#pragma once

#include <optional>
#include <vector>

#include <chasles/initialise/dynamic_window.hpp>
#include <chasles/initialise/preintegration.hpp>

namespace chasles {

/// Truncation of a view's residual, in standard deviations. The residual includes the errors of the
/// IMU.
inline constexpr double kTruncation = 8;

/// Velocity and gravity from the tracks, in the IMU's axes of the first keyframe.
struct LinearMotion {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();        ///< [m/s]
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< with the given magnitude
  double free_gravity = 0;                            ///< magnitude without that constraint [m/s^2]
  double free_gravity_sigma = 0;  ///< its standard deviation, from pixel noise alone
  double cost = 0;                ///< squared residuals of all views, each at most kTruncation^2
};

/// Estimates velocity and gravity by linear least squares (Martinelli 2014; Dong-Si & Mourikis
/// 2012).
/// The camera centre c = v t + g t^2 / 2 + (known) and the point x of a track satisfy (1 - u u^T)
/// (x - c) = 0 for the ray u of every view. This is linear in v, g and the points. The points are
/// eliminated track by track. Of many subsets of eight tracks, the one whose motion agrees with
/// most views is chosen (truncated sum, deterministic). The tracks that fit this motion are solved
/// together, weighted by range, so that angles are minimised. Then gravity is constrained to its
/// sphere of radius `gravity` [m/s^2]. The accelerometer bias is that of the preintegrations; its
/// remaining error goes into gravity.
/// None with fewer than eight tracks, or where the equations have no solution.
std::optional<LinearMotion> linear_motion(const MotionWindow& window,
                                          const std::vector<Preintegration>& between,
                                          double gravity);

}  // namespace chasles
