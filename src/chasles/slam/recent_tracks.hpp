#pragma once

#include <vector>

namespace chasles {

/// What tracks outside of the state have done for the filter of late.
struct TrackUse {
  int told = 0;     ///< of the clones, in the last frames
  int refused = 0;  ///< by the gate, in the same
  int waiting = 0;  ///< in view with two views and more: they will tell
};

/// Counts it. A track tells when it ends, or when its oldest clone has to go: not in every frame,
/// and at the beginning not for a whole window of clones. So those that wait count as well, but
/// only for that long: where a window has passed and none of them could tell, they tell nothing.
class RecentTracks {
 public:
  /// `frames`: that count as the last ones. `window`: frames that a track waits at most.
  RecentTracks(int frames, int window);

  void note(bool told);
  /// With the frame that ends now.
  TrackUse end_frame(int waiting);

 private:
  struct Ended {
    int told = 0, refused = 0;
  };
  std::vector<Ended> last_;  ///< of the last frames, the present one at `now_`
  std::size_t now_ = 0;
  int window_;
  int in_vain_ = 0;  ///< frames since a track told or none waited
};

}  // namespace chasles
