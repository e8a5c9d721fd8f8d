#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <chasles/recording/recording.hpp>

namespace chasles {

/// The cameras that a run uses, in their order: the numbers of an option like `0,2,3`; `mono` is 0
/// and `stereo` 0,1. None for an empty text: all cameras. Throws UsageError for a text that is no
/// such list, names a camera twice, or more than kMostCameras.
std::optional<std::vector<std::size_t>> camera_choice(const std::string& text);

inline constexpr std::size_t kMostCameras = 8;

/// How many of a recording's first cameras a choice needs.
std::size_t cameras_to_read(const std::optional<std::vector<std::size_t>>& choice);

/// Keeps only these cameras, in this order, and the frames in which one of them has an image.
/// Throws UsageError for a camera that the recording does not have, or that has no images.
void choose_cameras(Recording& recording, const std::vector<std::size_t>& choice);

}  // namespace chasles
