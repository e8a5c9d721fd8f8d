#pragma once

#include <optional>
#include <span>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/target/target.hpp>

namespace chasles {

/// The lens of a camera from views of a target alone, near enough for a search: an equidistant lens
/// of one coefficient, whose focal length is the best of those of 20 to 230 degrees. `size`: width
/// and height. None if no view has a pose.
std::optional<Camera> guessed_camera(const Camera& size, std::span<const Eigen::Vector3d> corners,
                                     const std::vector<const TargetView*>& views);

}  // namespace chasles
