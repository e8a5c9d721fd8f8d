#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>

#include <chasles/data/recording.hpp>

namespace chasles {

/// Makes the folder ready for `write_euroc`: it is made where it is missing, and what an earlier
/// write left in it is removed. UsageError where that is not possible, or where the folder holds
/// anything that was not written by `write_euroc`: a real recording is never replaced.
void prepare_euroc_folder(const std::filesystem::path& folder);

/// Writes IMU, images and truth as an EuRoC recording (Burri et al. 2016): mav0/imu0, mav0/camN
/// with PNG files named by their times [ns], mav0/state_groundtruth_estimate0. T_BS of a camera is
/// imu_T_cam. A truth whose velocities and biases are not known goes to truth.tum instead, which
/// the reader takes as well; a plan to plan.csv in the folder. Lists of images are written last: a
/// folder without cam0/data.csv is incomplete.
///
/// `threads`: so many frames at a time are read and written, each on a thread of its own; with more
/// than one `recording.images` must allow that. The files are the same. `done`, if any, is called
/// with the number of frames written whenever so many more are; if it returns false, the recording
/// ends there. Returns the number of frames. UsageError where a file cannot be written, as for want
/// of space, where the recording has no images, cameras, samples or noise densities, or where an
/// image is not of its camera's size.
std::size_t write_euroc(const Recording& recording, const std::filesystem::path& folder,
                        const std::function<bool(std::size_t)>& done = {}, int threads = 1);

}  // namespace chasles
