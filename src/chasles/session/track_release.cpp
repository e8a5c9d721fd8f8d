#include <chasles/session/track_release.hpp>

namespace chasles {

// Whoever reads ahead on another thread has copied all frames up to this one.
void TrackRelease::on_frame(const FeatureFrame& frame) {
  if (!started_) return;
  std::vector<FeatureFrame>& frames = recording_.frames;
  for (; released_ < frames.size() && frames[released_].time <= frame.time; ++released_) {
    frames[released_] = {.time = frames[released_].time};
  }
}

}  // namespace chasles
