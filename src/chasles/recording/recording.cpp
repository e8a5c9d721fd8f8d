#include <algorithm>

#include <chasles/recording/recording.hpp>

namespace chasles {

std::size_t frame_count(const Recording& r) {
  return r.frames.size() + (r.images ? r.images->size() : 0);
}

Time frame_time(const Recording& r, std::size_t i) {
  return i < r.frames.size() ? r.frames[i].time : r.images->time(i - r.frames.size());
}

std::optional<double> frame_interval(const Recording& r, std::size_t camera) {
  std::vector<double> intervals;
  std::optional<Time> last;
  const auto take = [&](Time time) {
    if (last) intervals.push_back(to_seconds(time - *last));
    last = time;
  };
  for (const FeatureFrame& frame : r.frames) {
    if ((observing(frame) & camera_bit(static_cast<int>(camera))) != 0) take(frame.time);
  }
  for (std::size_t i = 0; r.images && i < r.images->size(); ++i) {
    if (r.images->has_image(i, camera)) take(r.images->time(i));
  }
  if (intervals.empty()) return std::nullopt;
  const auto middle = intervals.begin() + std::ssize(intervals) / 2;
  std::ranges::nth_element(intervals, middle);
  return *middle;
}

Time first_event(const Recording& r) {
  Time first = Time::max();
  if (!r.frames.empty()) first = std::min(first, r.frames.front().time);
  if (!r.velocities.empty()) first = std::min(first, r.velocities.front().time);
  if (!r.imu.empty()) first = std::min(first, r.imu.front().time);
  if (r.images && r.images->size() > 0) first = std::min(first, r.images->time(0));
  return first;
}

std::optional<Event> EventStream::next() {
  const auto& velocities = recording_->velocities;
  const auto& imu = recording_->imu;
  const auto& frames = recording_->frames;
  constexpr Time kNever = Time::max();
  const Time velocity = velocity_ < velocities.size() ? velocities[velocity_].time : kNever;
  const Time sample = imu_ < imu.size() ? imu[imu_].time : kNever;
  const Time frame = frame_ < frames.size() ? frames[frame_].time : kNever;
  const std::size_t image_count = recording_->images ? recording_->images->size() : 0;
  const Time image = image_ < image_count ? recording_->images->time(image_) : kNever;
  const Time seen = std::min(frame, image);
  if (velocity_ < velocities.size() && velocity <= sample && velocity <= seen) {
    return velocities[velocity_++];
  }
  const bool needed = imu_ == 0 || imu[imu_ - 1].time < seen;
  if (imu_ < imu.size() && needed) return imu[imu_++];
  if (frame_ < frames.size() && frame <= image) return frames[frame_++];
  if (image_ < image_count) return ImagesDue{.time = image, .index = image_++};
  return std::nullopt;
}

}  // namespace chasles
