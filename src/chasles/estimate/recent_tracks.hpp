#pragma once

#include <vector>

namespace chasles {

/// Null-space updates with tracks whose points are not in the state.
struct TrackUse {
  int used = 0;      ///< tracks used in the last frames
  int rejected = 0;  ///< by the gate, in the same frames
  int waiting = 0;   ///< in view with two or more observations: an update is still to come
};

/// Counts null-space updates. A track makes its update when it ends or when its oldest clone is
/// removed. So there is no update in every frame, and none before a whole window of clones exists.
/// Waiting tracks count as well, but only for the length of a window.
class RecentTracks {
 public:
  /// `frames`: the number of last frames that count. `window`: the maximum number of frames for
  /// which a track waits.
  RecentTracks(int frames, int window);

  void note(bool used);
  /// Ends the present frame.
  TrackUse end_frame(int waiting);

 private:
  struct Ended {
    int used = 0, rejected = 0;
  };
  std::vector<Ended> last_;  ///< of the last frames, the present one at index `now_`
  std::size_t now_ = 0;
  int window_;
  int in_vain_ = 0;  ///< frames since the last update, or since no track waited
};

}  // namespace chasles
