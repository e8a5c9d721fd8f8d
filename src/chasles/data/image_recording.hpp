#pragma once

#include <filesystem>

#include <chasles/data/recording.hpp>

namespace chasles {

// What the readers of images and IMU samples share.

/// Images of a rig whose times differ by less are of one instant.
inline constexpr Time kSameInstant = std::chrono::milliseconds(2);

/// Brings the samples into order, with remarks. `file` is named where there are none: InputError.
void tidy_samples(const std::filesystem::path& file, Recording& recording);

/// A remark on the frames that no IMU sample surrounds.
void remark_on_coverage(Recording& recording);

}  // namespace chasles
