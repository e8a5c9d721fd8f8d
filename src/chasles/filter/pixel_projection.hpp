#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/filter/state.hpp>

namespace chasles {

/// A projection from a pose and its derivatives by the point (p_world and w) and by the pose. The
/// latter is d_point times [p - w p_imu]x and -w I (reference chart; docs/derivations.md, D38).
struct Seen {
  Eigen::Vector2d residual;             ///< measured minus predicted [px]
  Eigen::Matrix<double, 2, 3> d_point;  ///< d predicted / d p_world [px/m]
  Eigen::Vector2d d_w;                  ///< d predicted / d w [px]
  Eigen::Matrix<double, 2, 6> d_pose;   ///< d predicted / d [rotation; position]
};

/// A projection does not depend on the scale of the homogeneous point, so w need not be positive.
/// None if the point has no projection (project), or is nearer than least_depth [m], to the plane
/// or the camera as there.
std::optional<Seen> see(const Camera& camera, const SE3& world_T_imu, const HomogeneousPoint& point,
                        const Eigen::Vector2d& pixel, double least_depth = kMinDepth);
/// The same with these extrinsics instead of the camera's.
std::optional<Seen> see(const Camera& camera, const SE3& cam_T_imu, const SE3& world_T_imu,
                        const HomogeneousPoint& point, const Eigen::Vector2d& pixel,
                        double least_depth = kMinDepth);

/// The point in the camera's frame, times w [m].
Eigen::Vector3d in_camera(const Camera& camera, const SE3& world_T_imu,
                          const HomogeneousPoint& point);

/// d predicted / d (errors of imu_T_camera) of the same projection, p_cam = R_ic^T (p_imu - p_ic).
/// The camera's extrinsics may be those at a line (at_line).
Eigen::Matrix<double, 2, 6> derivative_by_camera(const Camera& camera, const SE3& world_T_imu,
                                                 const HomogeneousPoint& point,
                                                 const Eigen::Matrix<double, 2, 3>& d_point,
                                                 const SE3& imu_T_line = {});

/// A derivative by errors of extrinsics that are in IMU axes at the time of the image, by those in
/// IMU axes at a line: the errors of imu_T_camera.
template <int Rows>
Eigen::Matrix<double, Rows, 6> by_axes_of_line(const Eigen::Matrix<double, Rows, 6>& d,
                                               const SE3& imu_T_line) {
  Eigen::Matrix<double, Rows, 6> turned;
  turned << d.template leftCols<3>() * imu_T_line.R, d.template rightCols<3>() * imu_T_line.R;
  return turned;
}

/// The point of an anchored landmark, given its anchor: State::homogeneous without a state.
HomogeneousPoint homogeneous(const Clone& anchor, const Landmark& landmark);

}  // namespace chasles
