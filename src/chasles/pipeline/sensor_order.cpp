#include <algorithm>
#include <utility>

#include <chasles/pipeline/sensor_order.hpp>
#include <chasles/recording/image_recording.hpp>

namespace chasles {
namespace {

// The place of a time in a list that rises strictly; none if it is taken.
template <typename Timed>
std::optional<typename std::deque<Timed>::iterator> place_for(Time time, std::deque<Timed>& list) {
  const auto earlier = [](const Timed& one, Time t) { return one.time < t; };
  const auto place = std::lower_bound(list.begin(), list.end(), time, earlier);
  if (place != list.end() && place->time == time) return std::nullopt;
  return place;
}

}  // namespace

void SensorOrder::add(const ImuSample& sample) {
  if (!sample.specific_force_imu.allFinite() || !sample.angular_rate_imu.allFinite()) {
    ++counts_.unknown_samples;
    return;
  }
  const auto place = place_for(sample.time, samples_);
  if (!place || (last_sample_ && sample.time <= *last_sample_)) {
    ++counts_.late_samples;
    return;
  }
  samples_.insert(*place, sample);
  newest_ = std::max(newest_.value_or(sample.time), sample.time);
}

void SensorOrder::add(std::size_t camera, Time time, GrayImage image) {
  const auto place = place_for(time, cameras_[camera]);
  if (!place || (camera == 0 && last_frame_ && time <= *last_frame_)) {
    ++(camera == 0 ? counts_.late_images : counts_.unpaired);
    return;
  }
  cameras_[camera].insert(*place, {.time = time, .image = std::move(image)});
  silent_[camera] = false;
  newest_ = std::max(newest_.value_or(time), time);
}

// Whether nothing more is awaited for what has this time.
bool SensorOrder::gives_up(Time on) const {
  return finished_ || (newest_ && *newest_ - on > options_.patience);
}

// As in EventStream: before a frame come all samples up to the first that is not earlier.
bool SensorOrder::sample_is_due() const {
  if (samples_.empty()) return false;
  if (!last_sample_) return true;
  if (!cameras_[0].empty()) return *last_sample_ < cameras_[0].front().time;
  return (last_frame_ && *last_sample_ <= *last_frame_) || gives_up(samples_.front().time);
}

// Whether the image of this camera for the frame is there, or does not exist.
bool SensorOrder::is_decided(std::size_t camera, Time frame) const {
  return !cameras_[camera].empty() && cameras_[camera].back().time >= frame;
}

// VisualInertialSlam would give up a frame that waits there for its samples, however long it may
// wait here.
bool SensorOrder::frame_is_due() const {
  if (cameras_[0].empty()) return false;
  const Time time = cameras_[0].front().time;
  const bool covered = last_sample_ && *last_sample_ >= time;
  bool complete = true;
  for (std::size_t c = 1; c < cameras_.size(); ++c) {
    complete = complete && (silent_[c] || is_decided(c, time));
  }
  return gives_up(time) || (covered && complete);
}

std::vector<SensorEvent> SensorOrder::take() {
  std::vector<SensorEvent> events;
  for (;;) {
    if (sample_is_due()) {
      last_sample_ = samples_.front().time;
      events.emplace_back(samples_.front());
      samples_.pop_front();
    } else if (frame_is_due()) {
      events.emplace_back(take_frame());
    } else {
      break;
    }
  }
  give_up_unpaired();
  return events;
}

std::vector<SensorEvent> SensorOrder::finish() {
  finished_ = true;
  return take();
}

// Without frames of the first camera the images of others would pile up.
void SensorOrder::give_up_unpaired() {
  if (!cameras_[0].empty()) return;
  for (std::size_t c = 1; c < cameras_.size(); ++c) {
    while (!cameras_[c].empty() && gives_up(cameras_[c].front().time)) {
      cameras_[c].pop_front();
      ++counts_.unpaired;
    }
  }
}

ImageFrame SensorOrder::take_frame() {
  ImageFrame frame{.time = cameras_[0].front().time, .images = {}};
  frame.images.push_back(std::move(cameras_[0].front().image));
  cameras_[0].pop_front();
  const std::optional<Time> next =
      cameras_[0].empty() ? std::nullopt : std::optional(cameras_[0].front().time);
  for (std::size_t c = 1; c < cameras_.size(); ++c) {
    silent_[c] = !is_decided(c, frame.time);
    frame.images.push_back(partner(cameras_[c], frame.time, next));
  }
  last_frame_ = frame.time;
  return frame;
}

// The image that is nearest to the frame, the earlier one of two. Images before it belong to no
// frame; those that are nearer to the next one stay.
GrayImage SensorOrder::partner(Images& images, Time frame, const std::optional<Time>& next) {
  const auto distance = [](Time a, Time b) { return std::chrono::abs(a - b); };
  std::optional<TimedImage> best;
  while (!images.empty()) {
    const Time time = images.front().time;
    if (time > frame + kSameInstant || (next && distance(time, *next) < distance(time, frame))) {
      break;
    }
    const bool of_last = last_frame_ && distance(time, *last_frame_) <= distance(time, frame);
    const bool near = distance(time, frame) <= kSameInstant && !of_last;
    if (near && (!best || distance(time, frame) < distance(best->time, frame))) {
      counts_.unpaired += best ? 1 : 0;
      best = std::move(images.front());
    } else {
      ++counts_.unpaired;
    }
    images.pop_front();
  }
  counts_.incomplete += best ? 0 : 1;
  return best ? std::move(best->image) : GrayImage{};
}

}  // namespace chasles
