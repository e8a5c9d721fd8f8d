#pragma once

#include <vector>

namespace chasles {

/// Null-space updates with tracks whose points are not in the state.
struct TrackUse {
  int used = 0;      ///< tracks, in the last frames
  int rejected = 0;  ///< by the gate, in the same frames
  int waiting = 0;   ///< in view, with two observations and more: an update is still to come
};

/// Counts them. A track makes an update when it ends, or when its oldest clone is removed: not in
/// every frame, and at the beginning not before a whole window of clones. So waiting tracks count
/// as well, but only for the length of a window: if none of them made an update by then, none will.
class RecentTracks {
 public:
  /// `frames`: that count as the last ones. `window`: frames that a track waits at most.
  RecentTracks(int frames, int window);

  void note(bool used);
  /// With the frame that ends now.
  TrackUse end_frame(int waiting);

 private:
  struct Ended {
    int used = 0, rejected = 0;
  };
  std::vector<Ended> last_;  ///< of the last frames, the present one at `now_`
  std::size_t now_ = 0;
  int window_;
  int in_vain_ = 0;  ///< frames since a track made an update or none waited
};

}  // namespace chasles
