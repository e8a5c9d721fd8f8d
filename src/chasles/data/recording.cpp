#include <chasles/data/recording.hpp>

namespace chasles {

std::optional<Event> EventStream::next() {
  const auto& velocities = recording_->velocities;
  const auto& frames = recording_->frames;
  const bool velocity_left = velocity_ < velocities.size();
  const bool frame_left = frame_ < frames.size();
  if (velocity_left && (!frame_left || velocities[velocity_].time <= frames[frame_].time)) {
    return velocities[velocity_++];
  }
  if (frame_left) return frames[frame_++];
  return std::nullopt;
}

}  // namespace chasles
