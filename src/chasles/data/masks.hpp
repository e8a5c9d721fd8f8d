#pragma once

#include <string>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/image_frame.hpp>

namespace chasles {

/// The masks that a setting names: image files separated by commas, one per camera in order.
/// Returns one image per camera, empty where there is no mask (an empty name, or fewer names than
/// cameras), and an empty list for an empty text. The front end ignores black pixels (0). Throws
/// UsageError for more names than cameras, and InputError for a file that cannot be read or has
/// another size than its camera.
std::vector<GrayImage> read_masks(const std::string& names, const std::vector<Camera>& cameras);

}  // namespace chasles
