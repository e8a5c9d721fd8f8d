#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// The masks that a setting names: image files separated by commas, one per camera in order.
/// Returns one image per camera, empty where there is no mask (an empty name, or fewer names than
/// cameras), and an empty list for an empty text. The front end ignores black pixels (0); their
/// transparency does not count. Throws UsageError for more names than cameras, and InputError for a
/// file that cannot be read, has another size than its camera, or covers the whole image.
std::vector<GrayImage> read_masks(const std::string& names, const std::vector<Camera>& cameras);

/// The masks of a run: those of the setting, as read_masks(); without it the recording's own.
std::vector<GrayImage> masks_of(const std::string& names, const Recording& recording);

/// What the grey of a mask's file says.
enum class MaskKind {
  kBlackHides,  ///< as the setting has it
  kWhiteHides,  ///< any other grey, as the slam_mask.png of UMI has it
};

/// The mask of a file, for Recording::masks. Throws InputError as read_masks().
GrayImage read_mask(const std::filesystem::path& file, MaskKind kind, const Camera& camera);

/// The share of the pixels that a mask covers: 0 of an empty one.
double covered_share(const GrayImage& mask);

/// A sentence for each mask that does not do what masks are for: it covers nothing, or nearly all
/// of the image. Throws as read_masks().
std::vector<std::string> mask_remarks(const std::string& names, const std::vector<Camera>& cameras);

}  // namespace chasles
