#include <algorithm>

#include <chasles/estimate/recent_tracks.hpp>

namespace chasles {

RecentTracks::RecentTracks(int frames, int window)
    : last_(static_cast<std::size_t>(std::max(frames, 1))), window_(window) {}

void RecentTracks::note(bool used) { ++(used ? last_[now_].used : last_[now_].rejected); }

TrackUse RecentTracks::end_frame(int waiting) {
  TrackUse use;
  for (const Ended& ended : last_) {
    use.used += ended.used;
    use.rejected += ended.rejected;
  }
  in_vain_ = use.used > 0 || waiting == 0 ? 0 : in_vain_ + 1;
  if (in_vain_ <= window_) use.waiting = waiting;
  now_ = (now_ + 1) % last_.size();
  last_[now_] = {};
  return use;
}

}  // namespace chasles
