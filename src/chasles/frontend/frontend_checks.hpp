#pragma once

#include <optional>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/frontend/frontend.hpp>

namespace chasles {

/// Throws UsageError, naming the camera, if a camera or a mask (empty: none) cannot be used.
void check_rig(const std::vector<Camera>& cameras, const std::vector<GrayImage>& masks);

/// Throws InputError if a frame is not later than `last`, does not match the rig, or its predicted
/// rotation is not a rotation.
void check_frame(const ImageFrame& frame, const RotationPrior& rotation, std::optional<Time> last,
                 const std::vector<Camera>& cameras);

}  // namespace chasles
