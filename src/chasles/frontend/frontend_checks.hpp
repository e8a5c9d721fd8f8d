#pragma once

#include <optional>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/frontend/frontend.hpp>

namespace chasles {

/// Throws UsageError, naming the camera, where a camera or a mask (empty: none) cannot be used.
void check_rig(const std::vector<Camera>& cameras, const std::vector<GrayImage>& masks);

/// Throws InputError where a frame cannot follow one at the time `last`, or does not fit the rig,
/// or its rotation is none.
void check_frame(const ImageFrame& frame, const RotationPrior& rotation, std::optional<Time> last,
                 const std::vector<Camera>& cameras);

}  // namespace chasles
