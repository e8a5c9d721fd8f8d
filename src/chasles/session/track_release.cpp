#include <chasles/base/free_memory.hpp>
#include <chasles/session/track_release.hpp>

namespace chasles {
namespace {

constexpr std::size_t kBytesToReturn = 16 << 20;

std::size_t bytes_of(const FeatureFrame& frame) {
  return sizeof(StereoObservation) * frame.observations.capacity() +
         sizeof(PixelObservation) * frame.pixels.capacity();
}

}  // namespace

// Whoever reads ahead on another thread has copied all frames up to this one.
void TrackRelease::on_frame(const FeatureFrame& frame) {
  if (!started_) return;
  std::vector<FeatureFrame>& frames = recording_.frames;
  for (; released_ < frames.size() && frames[released_].time <= frame.time; ++released_) {
    bytes_ += bytes_of(frames[released_]);
    frames[released_] = {.time = frames[released_].time};
  }
  if (bytes_ < kBytesToReturn) return;
  bytes_ = 0;
  return_free_memory();
}

}  // namespace chasles
