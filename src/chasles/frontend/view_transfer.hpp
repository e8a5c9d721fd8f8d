#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

/// The position of a pixel of one view in another one, and the deformation of its surroundings.
struct Transfer {
  Eigen::Vector2d pixel;            ///< in the other view, possibly outside its image [px]
  Eigen::Matrix2d to_A_from;        ///< d pixel / d pixel of the first view
  Eigen::Vector2d d_inverse_depth;  ///< d pixel / d inverse depth [px m]
};

/// The projection into the camera `to` of the point on the ray (x/z, y/z, 1) of another camera at
/// this inverse depth 1/z [1/m] (0: at infinity). None if the point has no projection. The
/// derivatives assume equal depth for neighbouring pixels.
std::optional<Transfer> transfer(const WideRay& from, double inverse_depth, const SE3& to_T_from,
                                 const Camera& to);

/// The second-order part of the pixels of camera `from` around a pixel of camera `to`, for points
/// at infinity: bow (o_x^2, o_x o_y, o_y^2) at offset o in `to`, by differences over `reach` [px].
/// Zero where one of the pixels has no direction or no projection. It is large where two cameras
/// look into different directions: lines bend to different sides at the rims of cameras back to
/// back.
Eigen::Matrix<double, 2, 3> transfer_bow(const Camera& from, const Camera& to,
                                         const Eigen::Matrix3d& to_R_from,
                                         const Eigen::Vector2d& pixel, double reach);

}  // namespace chasles
