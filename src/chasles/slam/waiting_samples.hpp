#pragma once

#include <deque>

#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// IMU samples, in the order of their arrival, that wait until a run starts. The start uses those
/// since a time not long before it.
class WaitingSamples {
 public:
  void add(const ImuSample& sample) { samples_.push_back(sample); }
  /// Removes those that no start at this time or later uses. The last one before it stays, as the
  /// begin of the first interval, and so do the newest two: a wrong time removes not all.
  void drop_before(Time time) {
    while (samples_.size() > 2 && samples_[1].time < time) samples_.pop_front();
  }
  void clear() { samples_.clear(); }

  bool empty() const { return samples_.empty(); }
  const ImuSample& newest() const { return samples_.back(); }
  const std::deque<ImuSample>& all() const { return samples_; }

 private:
  std::deque<ImuSample> samples_;
};

}  // namespace chasles
