#include <algorithm>

#include <chasles/slam/clone_window.hpp>

namespace chasles {

void CloneWindow::augment(SlamContext& x, const FeatureFrame& frame, bool standstill) {
  augmented_ =
      x.settings.init == LandmarkInit::kMultiView && is_due(x.settings, frame) && !standstill;
  if (!augmented_) return;
  x.keep_pose(frame.time);
  window_.push_back(x.frame);
}

// Counts frames during a standstill too. A frame may be a little early for the interval.
bool CloneWindow::is_due(const InertialSlamSettings& settings, const FeatureFrame& frame) {
  constexpr double kEarly = 0.95;
  if (observing(frame) == 0) return false;
  const bool due = !last_ || ++since_ >= settings.frames_per_clone ||
                   to_seconds(frame.time - *last_) >= kEarly * settings.clone_interval;
  if (!due) return false;
  since_ = 0;
  last_ = frame.time;
  return true;
}

void CloneWindow::remove_unused(SlamContext& x, const Reused<WaitingTrack>& tracks,
                                std::optional<int> of_standstill) {
  used_.clear();
  unused_.clear();
  for (const Landmark& landmark : x.state().landmarks) {
    if (landmark.anchor) used_.push_back(*landmark.anchor);
  }
  if (of_standstill) used_.push_back(*of_standstill);
  for (const WaitingTrack& track : tracks) {
    for (const ClonedView& view : track.views) used_.push_back(view.clone);
  }
  std::sort(used_.begin(), used_.end());
  for (const Clone& clone : x.state().clones) {
    if (!std::binary_search(used_.begin(), used_.end(), clone.id)) unused_.push_back(clone.id);
  }
  x.filter.remove_clones(unused_);
}

}  // namespace chasles
