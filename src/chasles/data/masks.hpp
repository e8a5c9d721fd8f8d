#pragma once

#include <string>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/image_frame.hpp>

namespace chasles {

/// The masks that a setting names: PNG or JPEG files, one a camera in their order, separated by
/// commas. One image a camera, empty where there is none (an empty name, or fewer names than
/// cameras); none at all for an empty text. Black (0) is what is not looked at. Throws UsageError
/// for more names than cameras, InputError for a file that cannot be read or is not of its camera's
/// size.
std::vector<GrayImage> read_masks(const std::string& names, const std::vector<Camera>& cameras);

}  // namespace chasles
