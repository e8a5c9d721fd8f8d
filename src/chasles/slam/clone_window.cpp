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
  const CameraSet cameras = observing(frame);
  const auto each = [&](const auto& visit) {
    for (std::size_t c = 0; c < due_.size(); ++c) {
      if ((cameras & camera_bit(static_cast<int>(c))) != 0) visit(due_[c]);
    }
  };
  bool due = false;
  each([&](Due& of) {
    due |= !of.last || ++of.since >= settings.frames_per_clone ||
           to_seconds(frame.time - *of.last) >= kEarly * settings.clone_interval;
  });
  if (due) each([&](Due& of) { of = {.last = frame.time}; });
  return due;
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
