#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/recording/image_files.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

// Shared by the readers of images and IMU samples.

/// Images of a rig whose times differ by less belong to one frame.
inline constexpr Time kSameInstant = std::chrono::milliseconds(2);

/// Spreads batches of samples with one time (sample_batches.hpp), sorts the samples by time, and
/// leaves out those that are not finite, with remarks. Throws
/// InputError, with the name `file`, if none is left, or if most have the time of another.
void tidy_samples(const std::filesystem::path& file, Recording& recording);

/// The second part of it, for tables whose times must rise strictly.
void leave_out_not_finite(const std::filesystem::path& file, Recording& recording);

/// A stamp by the IMU's clock: `stamp` + `offset`. Throws InputError, starting with `where`, if
/// that is no time that can be read.
Time by_imu_clock(Time stamp, Time offset, const std::string& where);

/// Opens the images of recording.cameras as recording.images; one entry of `files` for each camera,
/// none where there are no images. A later camera without images is left out, with a remark.
/// `offsets`: of each camera, added to its stamps; empty: none. Throws InputError as
/// open_image_files(), and if the first camera, whose folder is `first`, has no images.
void open_cameras(std::vector<std::optional<CameraFiles>> files, const std::vector<Time>& offsets,
                  const std::filesystem::path& first, Recording& recording);

/// Adds a remark on a folder camN of `folder` that the calibration has no camera for.
void remark_on_further_camera(const std::filesystem::path& folder, Recording& recording);

/// Adds a remark on frames before the first IMU sample or after the last.
void remark_on_coverage(Recording& recording);

}  // namespace chasles
