#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>

namespace chasles {

/// Distorts a direction (x/z, y/z) by the camera's lens model (lenses/lens_model.hpp): its point on
/// the plane at unit focal length. None beyond the first fold of the model.
std::optional<DistortedPoint> distort(const Camera& camera, const Eigen::Vector2d& xy);

/// The direction (x/z, y/z) that distort maps to xy, to round-off; none if no direction in front of
/// the camera does.
std::optional<Eigen::Vector2d> undistort(const Camera& camera, const Eigen::Vector2d& xy);

}  // namespace chasles
