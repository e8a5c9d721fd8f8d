#include <chasles/data/recording.hpp>

namespace chasles {

std::optional<Event> EventStream::next() {
  const auto& velocities = recording_->velocities;
  const auto& imu = recording_->imu;
  const auto& frames = recording_->frames;
  constexpr Time kNever = Time::max();
  const Time velocity = velocity_ < velocities.size() ? velocities[velocity_].time : kNever;
  const Time sample = imu_ < imu.size() ? imu[imu_].time : kNever;
  const Time frame = frame_ < frames.size() ? frames[frame_].time : kNever;
  if (velocity_ < velocities.size() && velocity <= sample && velocity <= frame) {
    return velocities[velocity_++];
  }
  const bool needed = imu_ == 0 || imu[imu_ - 1].time < frame;
  if (imu_ < imu.size() && needed) return imu[imu_++];
  if (frame_ < frames.size()) return frames[frame_++];
  return std::nullopt;
}

}  // namespace chasles
