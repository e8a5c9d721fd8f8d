#pragma once

#include <filesystem>

#include <chasles/recording/recording.hpp>

namespace chasles {

/// Whether a folder has images of a target and nothing else that a recording needs: images, or a
/// folder camN of images for each camera, also in `images/`; no calibration and no table of an IMU.
bool is_target_images(const std::filesystem::path& folder);

/// Images without calibration and times, as of a photo camera: their cameras have a size alone
/// (fx = 0). Images of several cameras with the same name are of the same instant. The time is the
/// number that the name has, in ns, if it has 10 digits or more in all names; else the images
/// are one second apart, in the order of their names.
///
/// Throws InputError for a folder without images. An image of another size than its camera's first
/// is damaged (ImageSource::read_undamaged).
Recording read_target_images(const std::filesystem::path& folder);

}  // namespace chasles
