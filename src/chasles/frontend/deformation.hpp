#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/frontend/image_pyramid.hpp>
#include <chasles/frontend/patch.hpp>

namespace chasles {

/// How an image near a place where a patch was found differs from the patch beyond gain and offset:
/// its pixel at centre + shift + (1 + bend) o is the patch's at o.
struct Deformation {
  Eigen::Vector2f shift = Eigen::Vector2f::Zero();  ///< [px]
  Eigen::Matrix2f bend = Eigen::Matrix2f::Zero();
};

/// One Gauss-Newton step for all six numbers together, from the place that align() found. The bend
/// is held to be small, as it is from one image to the next, so that a patch that does not tell it
/// leaves it alone. None where `centre` is outside the image, or where the patch is hardly there
/// (its gain is below 0.3).
std::optional<Deformation> deformation(const Patch& patch, const PyramidLevel& level,
                                       const Eigen::Vector2f& centre);

}  // namespace chasles
