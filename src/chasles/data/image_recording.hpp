#pragma once

#include <filesystem>

#include <chasles/data/recording.hpp>

namespace chasles {

// Shared by the readers of images and IMU samples.

/// Images of a rig whose times differ by less belong to one frame.
inline constexpr Time kSameInstant = std::chrono::milliseconds(2);

/// Sorts the samples by time, with remarks. Throws InputError, with the name `file`, if there are
/// none.
void tidy_samples(const std::filesystem::path& file, Recording& recording);

/// Adds a remark on frames before the first IMU sample or after the last.
void remark_on_coverage(Recording& recording);

}  // namespace chasles
