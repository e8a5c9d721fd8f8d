#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/filter/state.hpp>

namespace chasles {

/// A projection from a pose and its derivatives by the point (p_world and w) and by the pose,
/// [p - w p_imu]x and -w I behind d_point (reference chart; docs/derivations.md, D38).
struct Seen {
  Eigen::Vector2d residual;             ///< measured less predicted [px]
  Eigen::Matrix<double, 2, 3> d_point;  ///< d predicted / d p_world [px/m]
  Eigen::Vector2d d_w;                  ///< d predicted / d w [px]
  Eigen::Matrix<double, 2, 6> d_pose;   ///< d predicted / d [rotation; position]
};

/// Projections do not depend on a point's scale, and so not on whether w is positive. None where
/// the camera does not see the point (project), or where that is nearer than least_depth [m].
std::optional<Seen> see(const Camera& camera, const SE3& world_T_imu, const HomogeneousPoint& point,
                        const Eigen::Vector2d& pixel, double least_depth = kMinDepth);

/// d predicted / d (errors of imu_T_camera) of the same, p_cam = R_ic^T (p_imu - p_ic).
Eigen::Matrix<double, 2, 6> derivative_by_camera(const Camera& camera, const SE3& world_T_imu,
                                                 const HomogeneousPoint& point,
                                                 const Eigen::Matrix<double, 2, 3>& d_point);

/// Where an anchored landmark is, from its anchor: State::homogeneous without a state.
HomogeneousPoint homogeneous(const Clone& anchor, const Landmark& landmark);

}  // namespace chasles
