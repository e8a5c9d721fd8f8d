#pragma once

#include <optional>
#include <vector>

#include <chasles/slam/dynamic_window.hpp>
#include <chasles/slam/preintegration.hpp>

namespace chasles {

/// A view's residual counts no more than so many standard deviations; the IMU's errors are in it.
inline constexpr double kTruncation = 8;

/// Velocity and gravity from the tracks, in the IMU's axes of the first keyframe.
struct LinearMotion {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();        ///< [m/s]
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< of the magnitude that was asked for
  double free_gravity = 0;                            ///< magnitude without that [m/s^2]
  double free_gravity_sigma = 0;                      ///< its deviation for the pixels' noise alone
  std::vector<bool> fits;                             ///< track by track
  double cost = 0;  ///< squared residuals of all views, each at most kTruncation^2
};

/// The camera centre c = v t + g t^2 / 2 + (known) and the point x of a track satisfy
/// (1 - u u^T) (x - c) = 0 for the ray u of every view: linear in v, g and the points (Martinelli
/// 2014; Dong-Si & Mourikis 2012). The points are eliminated track by track; of subsets of eight
/// tracks that one counts whose motion most views agree with (truncated sum, deterministic); the
/// tracks that fit it are solved together, weighted by range, so that angles are made least. Then
/// gravity is held on its sphere. The accelerometer's bias is taken as the preintegrations have it;
/// what is left of it goes into gravity. None with fewer than eight tracks or where the equations
/// have no solution.
std::optional<LinearMotion> linear_motion(const MotionWindow& window,
                                          const std::vector<Preintegration>& between,
                                          double gravity);

}  // namespace chasles
