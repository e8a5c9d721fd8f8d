#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/lie/se3.hpp>

namespace chasles {

/// A rectified stereo pair: two equal pinhole cameras. The right one is displaced by the baseline
/// along the x axis of the left one (Du, eq. 2). Camera frame: z forward, x right, y down. Pixels
/// (uL, vL, uR, vR).
struct StereoRig {
  double fx = 0, fy = 0;  ///< focal lengths [px]
  double cx = 0, cy = 0;  ///< principal point [px]
  double baseline = 0;    ///< [m], positive
  SE3 cam0_T_imu;         ///< maps IMU coordinates to those of the left camera
};

/// Points nearer than this to the image plane have no projection [m].
inline constexpr double kMinDepth = 0.1;

/// A projection and its derivative.
struct StereoProjection {
  Eigen::Vector4d pixels;               ///< (uL, vL, uR, vR)
  Eigen::Matrix<double, 4, 3> d_point;  ///< d pixels / d p_cam0  [px/m]
};

/// The pixels of a point in the left camera's frame [m]; none if the point lies behind the cameras
/// or nearer than kMinDepth.
std::optional<StereoProjection> project(const StereoRig& rig, const Eigen::Vector3d& p_cam0);

/// A triangulated point and its derivative.
struct StereoPoint {
  Eigen::Vector3d p_cam0;                ///< [m]
  Eigen::Matrix<double, 3, 4> d_pixels;  ///< d p_cam0 / d (uL, vL, uR, vR)  [m/px]
};

/// The point of four pixels (Du, eq. 17-19, with vL and vR averaged); none if the disparity uL - uR
/// is not positive.
std::optional<StereoPoint> triangulate(const StereoRig& rig, const Eigen::Vector4d& pixels);

}  // namespace chasles
