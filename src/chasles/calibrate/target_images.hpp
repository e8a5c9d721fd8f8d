#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/recording/recording.hpp>

namespace chasles {

/// The folders of the images of each camera: cam0, cam1, … in a folder, in its folder images or
/// mav0, or the folders data in those; without them the folder itself.
std::vector<std::filesystem::path> target_image_folders(const std::filesystem::path& folder);

/// Whether a folder has images of a target and nothing else that a recording needs: images, or a
/// folder camN of images for each camera, also in `images/`; no calibration and no table of an IMU.
/// The file of the target may be there.
bool is_target_images(const std::filesystem::path& folder);

/// Images without calibration and times, as of a photo camera: their cameras have a size alone
/// (fx = 0). Images of several cameras with the same name are of the same instant. Times are those
/// of times_of_names().
///
/// Throws InputError for a folder without images. An image of another size than its camera's first
/// is damaged (ImageSource::read_undamaged).
Recording read_target_images(const std::filesystem::path& folder);

/// A recording of a target: such images, an uncalibrated recording (is_uncalibrated()), or one of
/// any kind. Throws as their readers.
Recording read_target_recording(const std::filesystem::path& path);

/// The times that names of images state, without endings, one for each, where all are stamps:
/// whole numbers of ten digits or more, but for dates of 14 digits, or numbers with decimals, each
/// with the same text before it, at 5000 Hz or less. Decimals are seconds; whole numbers are
/// nanoseconds, or micro- or milliseconds where the rate would be higher. Other names: one second
/// apart, in their order.
std::vector<Time> times_of_names(const std::vector<std::string>& names);

/// The file of an image of a recording; empty where it has none, and where images are no files.
std::filesystem::path target_image_file(const ImageSource& images, std::size_t i,
                                        std::size_t camera);

}  // namespace chasles
