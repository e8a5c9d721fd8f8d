#pragma once

#include <array>
#include <optional>
#include <vector>

#include <chasles/slam/slam_context.hpp>
#include <chasles/slam/waiting_track.hpp>

namespace chasles {

/// The clones of poses to which the views of tracks refer: which frames become one, and which of
/// them are needed no longer.
class CloneWindow {
 public:
  /// Makes the present pose a clone if one is due. During a standstill all poses are the same, and
  /// a pixel has the same error in all of them: none is made.
  void augment(SlamContext& x, const FeatureFrame& frame, bool standstill);
  /// Whether the present frame's pose is a clone of the window.
  bool augmented() const { return augmented_; }

  bool full(const InertialSlamSettings& settings) const {
    return static_cast<int>(window_.size()) >= settings.clones;
  }
  int oldest() const { return window_.front(); }
  /// Makes room for the next one. The clone remains in the state while something refers to it.
  void drop_oldest() { window_.erase(window_.begin()); }

  /// Removes the clones that no landmark, no track and no standstill refers to.
  void remove_unused(SlamContext& x, const Reused<WaitingTrack>& tracks,
                     std::optional<int> of_standstill);

 private:
  bool is_due(const InertialSlamSettings& settings, const FeatureFrame& frame);

  struct Due {
    int since = 0;             ///< frames with observations since a clone was due
    std::optional<Time> last;  ///< when it was due
  };

  std::array<Due, kCameraBits> due_;  ///< of each camera: they may take turns
  std::vector<int> window_;           ///< clones that views of tracks may refer to
  bool augmented_ = false;
  std::vector<int> used_, unused_;
};

}  // namespace chasles
