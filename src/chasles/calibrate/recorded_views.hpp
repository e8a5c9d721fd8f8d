#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <chasles/recording/recording.hpp>
#include <chasles/target/target.hpp>
#include <chasles/target/target_detector.hpp>

namespace chasles {

struct ViewOptions {
  int every = 1;    ///< of so many frames one is searched
  int threads = 1;  ///< the views do not depend on it
  /// Called from any thread after each frame, with the number of frames done; false: stop, and keep
  /// what is found.
  std::function<bool(std::size_t done)> progress = {};
  /// What an image shows that was searched before, by its file; null: it was not. Any thread.
  std::function<const TargetDetection*(const std::filesystem::path& file)> known = {};
};

/// The views of a target in a recording.
struct RecordedViews {
  std::vector<TargetView> views;  ///< by time and camera
  std::size_t frames = 0;         ///< that were searched
  std::vector<std::size_t> seen;  ///< of each camera: images with four corners or more
  std::vector<double> blur;  ///< of each view: standard deviation of its edges [px]; NaN: unknown
  std::vector<std::string> lacks;    ///< of each view: why corners are missing; empty: none are
  std::vector<std::string> damaged;  ///< images that cannot be read, one sentence each
};

/// The number of frames that recorded_views() searches.
std::size_t searched_frames(const Recording& recording, const ViewOptions& options);

/// Searches the images, or takes tracks for corners: the landmark is then the id of a corner.
/// Throws InputError for a recording with neither, and for tracks with other ids.
RecordedViews recorded_views(const Recording& recording, const Target& target,
                             const ViewOptions& options = {});

/// A sentence on each camera whose views are mostly blurred (BlurCount).
std::vector<std::string> blurred_views(const RecordedViews& views);

}  // namespace chasles
