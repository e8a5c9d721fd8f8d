#pragma once

#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/lie/se3.hpp>
#include <chasles/reconstruct/colmap_settings.hpp>

namespace chasles {

/// A frame that may become a keyframe.
struct KeyframeCandidate {
  SE3 world_T_imu;
  double sharpness = 0;                 ///< against its neighbours
  std::vector<LandmarkId> tracks = {};  ///< sorted, each once
};

/// The keyframes among frames in order of time, by spacing and sharpness as the settings state
/// them: the first one, and each that is due after the last, or a sharper one soon after it.
std::vector<std::size_t> choose_keyframes(const std::vector<KeyframeCandidate>& frames,
                                          const ColmapSettings& settings);

}  // namespace chasles
