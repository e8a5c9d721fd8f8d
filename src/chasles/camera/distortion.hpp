#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>

namespace chasles {

/// The image of a direction on the plane at unit focal length, and its derivative.
struct DistortedPoint {
  Eigen::Vector2d xy;    ///< (u - cx) / fx, (v - cy) / fy
  Eigen::Matrix2d d_xy;  ///< d xy / d (x/z, y/z)
};

/// Distorts a direction (x/z, y/z). With r = |(x/z, y/z)| and theta = atan r,
///   radtan       x r_d(r) / r + [2 p1 x y + p2 (r^2 + 2 x^2), p1 (r^2 + 2 y^2) + 2 p2 x y],
///                r_d = r (1 + k1 r^2 + k2 r^4 + k3 r^6)  (Brown 1966, as OpenCV calib3d)
///   equidistant  x theta_d / r,  theta_d = theta (1 + k1 theta^2 + ... + k4 theta^8)
///                (Kannala & Brandt 2006, as OpenCV fisheye)
/// None if the map folds over between the axis and the direction: the polynomials rise again beyond
/// a fold, and a second direction would map to the same pixel.
std::optional<DistortedPoint> distort(const Camera& camera, const Eigen::Vector2d& xy);

/// The direction (x/z, y/z) that distort maps to xy, to round-off; none if no direction in front of
/// the camera does.
std::optional<Eigen::Vector2d> undistort(const Camera& camera, const Eigen::Vector2d& xy);

}  // namespace chasles
