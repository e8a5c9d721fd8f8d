#include <algorithm>
#include <iterator>
#include <optional>

#include <chasles/base/constants.hpp>
#include <chasles/reconstruct/keyframes.hpp>

namespace chasles {
namespace {

// Of the first frame's tracks, those that the second one has.
double overlap(const KeyframeCandidate& a, const KeyframeCandidate& b) {
  if (a.tracks.empty()) return 0;
  std::vector<LandmarkId> common;
  std::ranges::set_intersection(a.tracks, b.tracks, std::back_inserter(common));
  return static_cast<double>(common.size()) / static_cast<double>(a.tracks.size());
}

// Of the second frame from the first, as a part of what makes a keyframe due.
double spacing(const KeyframeCandidate& a, const KeyframeCandidate& b,
               const ColmapSettings& settings) {
  const SE3 motion = a.world_T_imu.inverse() * b.world_T_imu;
  const double turned = so3::log(motion.R).norm() / (settings.rotation * kRadians);
  const double moved = settings.distance ? motion.p.norm() / *settings.distance : 0;
  return std::max({turned, moved, (1 - overlap(a, b)) / (1 - settings.overlap)});
}

}  // namespace

std::vector<std::size_t> choose_keyframes(const std::vector<KeyframeCandidate>& frames,
                                          const ColmapSettings& settings) {
  std::vector<std::size_t> sharp, chosen;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].sharpness >= settings.min_sharpness) sharp.push_back(i);
  }
  for (std::size_t i = 0; i < sharp.size(); ++i) {
    const KeyframeCandidate& due = frames[sharp[i]];
    if (!chosen.empty() && spacing(frames[chosen.back()], due, settings) < 1) continue;
    std::size_t best = i;
    for (std::size_t j = i + 1; j < sharp.size(); ++j) {
      if (spacing(due, frames[sharp[j]], settings) > settings.search) break;
      if (frames[sharp[j]].sharpness > frames[sharp[best]].sharpness) best = j;
    }
    chosen.push_back(sharp[best]);
    i = best;
  }
  return chosen;
}

}  // namespace chasles
