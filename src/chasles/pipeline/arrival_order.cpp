#include <algorithm>
#include <iterator>
#include <utility>

#include <chasles/pipeline/arrival_order.hpp>

namespace chasles {
namespace {

// Inserts by time, unless that is taken; whether it did. Most come in order.
template <typename Timed>
bool insert_by_time(Timed one, std::deque<Timed>& list) {
  auto place = list.end();
  while (place != list.begin() && std::prev(place)->time > one.time) --place;
  if (place != list.begin() && std::prev(place)->time == one.time) return false;
  list.insert(place, std::move(one));
  return true;
}

bool is_finite(const ImuSample& sample) {
  return sample.specific_force_imu.allFinite() && sample.angular_rate_imu.allFinite();
}

template <typename Event>
SensorEvent take_front(std::deque<Event>& list) {
  SensorEvent event = std::move(list.front());
  list.pop_front();
  return event;
}

}  // namespace

void ArrivalOrder::add(const ImuSample& sample) {
  ++counts_.samples;
  if (!is_finite(sample)) ++counts_.samples_not_finite;
  if ((last_sample_ && sample.time <= *last_sample_) || !insert_by_time(sample, samples_)) {
    ++counts_.samples_late;
    return;
  }
  if (is_finite(sample)) {
    covered_until_ = std::max(covered_until_.value_or(sample.time), sample.time);
  }
  if (samples_.size() > kMostSamples) {
    ++counts_.samples_dropped;
    samples_.pop_front();
  }
}

void ArrivalOrder::add(ImageFrame frame) {
  ++counts_.images;
  if ((last_frame_ && frame.time <= *last_frame_) || !insert_by_time(std::move(frame), frames_)) {
    ++counts_.images_late;
  }
}

bool ArrivalOrder::is_covered(const ImageFrame& frame) const {
  return covered_until_ && *covered_until_ >= frame.time;
}

std::optional<SensorEvent> ArrivalOrder::next() {
  const bool due =
      !frames_.empty() && (is_covered(frames_.front()) || frames_.size() > kMostFrames);
  return due ? next_at_end() : std::nullopt;
}

std::optional<SensorEvent> ArrivalOrder::next_at_end() {
  if (!samples_.empty() && (frames_.empty() || !passed_on_ || *passed_on_ < frames_.front().time)) {
    return take_sample();
  }
  if (!frames_.empty()) return take_frame();
  return std::nullopt;
}

SensorEvent ArrivalOrder::take_sample() {
  last_sample_ = samples_.front().time;
  if (is_finite(samples_.front())) passed_on_ = last_sample_;
  return take_front(samples_);
}

SensorEvent ArrivalOrder::take_frame() {
  if (!is_covered(frames_.front())) ++counts_.images_uncovered;
  last_frame_ = frames_.front().time;
  return take_front(frames_);
}

}  // namespace chasles
