#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>

#include <chasles/recording/recording.hpp>

namespace chasles {

/// Prepares the folder for write_euroc(): creates it if missing and removes the output of an
/// earlier call. Throws UsageError if that is not possible, or if the folder holds anything that
/// write_euroc() did not write. A real recording is never replaced.
void prepare_euroc_folder(const std::filesystem::path& folder);

/// Writes IMU, images and truth as an EuRoC recording (Burri et al. 2016): mav0/imu0, mav0/camN
/// with PNG files named by their times [ns], and mav0/state_groundtruth_estimate0. T_BS of a camera
/// is imu_T_cam. A truth without velocities and biases goes to truth.tum instead, which the reader
/// accepts as well; a plan goes to plan.csv in the folder. Lists of images are written last: a
/// folder without cam0/data.csv is incomplete.
///
/// `threads`: number of frames that are read and written at a time, each on its own thread. With
/// more than one, `recording.images` must allow concurrent reads. The files do not depend on it.
/// `done`, if given, is called with the number of frames written whenever more are finished; if it
/// returns false, the recording ends there. Returns the number of frames. Throws UsageError if a
/// file cannot be written, if the recording has no images, cameras, samples or noise densities, or
/// if an image does not have its camera's size.
std::size_t write_euroc(const Recording& recording, const std::filesystem::path& folder,
                        const std::function<bool(std::size_t)>& done = {}, int threads = 1);

}  // namespace chasles
