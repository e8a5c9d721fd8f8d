#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/frontend/image_pyramid.hpp>
#include <chasles/frontend/patch.hpp>

namespace chasles {

/// Deformation of a patch in an image, besides gain and offset: the image at centre + shift + (1 +
/// bend) o corresponds to the patch at o.
struct Deformation {
  Eigen::Vector2f shift = Eigen::Vector2f::Zero();  ///< [px]
  Eigen::Matrix2f bend = Eigen::Matrix2f::Zero();
};

/// One Gauss-Newton step for all six parameters, from the position that align() found. A prior
/// keeps the bend small, as it is from one image to the next, so that a patch that does not
/// constrain it leaves it unchanged. None if `centre` is outside the image, or if the gain of the
/// patch is below 0.3.
std::optional<Deformation> deformation(const Patch& patch, const PyramidLevel& level,
                                       const Eigen::Vector2f& centre);

}  // namespace chasles
