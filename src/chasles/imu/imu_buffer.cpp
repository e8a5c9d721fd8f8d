#include <algorithm>
#include <utility>

#include <chasles/imu/imu_buffer.hpp>

namespace chasles {
namespace {

bool reaches(const Eigen::Vector3d& value, double range) {
  return value.cwiseAbs().maxCoeff() >= range;
}

// The straight line through two samples, at the middle of [start, end]: the mean over it.
ImuSample mean_between(const ImuSample& before, const ImuSample& after, Time start, Time end) {
  const double at = (to_seconds(start - before.time) + to_seconds(end - before.time)) / 2;
  const double x = at / to_seconds(after.time - before.time);
  return {.time = end,
          .specific_force_imu = (1 - x) * before.specific_force_imu + x * after.specific_force_imu,
          .angular_rate_imu = (1 - x) * before.angular_rate_imu + x * after.angular_rate_imu};
}

}  // namespace

void ImuBuffer::add(const ImuSample& sample) {
  if (!sample.specific_force_imu.allFinite() || !sample.angular_rate_imu.allFinite()) {
    ++counts_.not_finite;
    return;
  }
  if (!samples_.empty()) {
    if (sample.time <= samples_.back().time) {
      ++counts_.not_later;
      return;
    }
    if (to_seconds(sample.time - samples_.back().time) > options_.max_interval) ++counts_.gaps;
  }
  if (reaches(sample.specific_force_imu, options_.accelerometer_range) ||
      reaches(sample.angular_rate_imu, options_.gyroscope_range)) {
    ++counts_.saturated;
  }
  ++counts_.used;
  samples_.push_back(sample);
}

std::vector<ImuInterval> ImuBuffer::between(Time from, Time to) {
  std::vector<ImuInterval> intervals;
  if (samples_.empty() || to <= from) return intervals;
  if (from < samples_.front().time || to > samples_.back().time) ++counts_.extrapolated;
  auto after = std::ranges::upper_bound(std::as_const(samples_), from, {}, &ImuSample::time);
  for (Time start = from; start < to;) {
    const Time end = after == samples_.end() ? to : std::min(to, after->time);
    intervals.push_back(interval(start, end, after));
    start = end;
    if (after != samples_.end() && after->time == end) ++after;
  }
  return intervals;
}

ImuInterval ImuBuffer::interval(Time start, Time end, const Position& after) const {
  ImuSample value;
  Time unmeasured{};
  if (after == samples_.begin()) {
    value = *after;
    unmeasured = after->time - start;
  } else {
    const ImuSample& before = *std::prev(after);
    if (after == samples_.end()) {
      value = before;
      unmeasured = end - before.time;
    } else {
      value = options_.convention == ImuConvention::kInstant
                  ? mean_between(before, *after, start, end)
                  : *after;
      unmeasured = after->time - before.time;
    }
  }
  return {.tau = to_seconds(end - start),
          .specific_force_imu = value.specific_force_imu,
          .angular_rate_imu = value.angular_rate_imu,
          .noise_scale = std::max(1.0, to_seconds(unmeasured) / options_.max_interval)};
}

void ImuBuffer::forget_before(Time time) {
  while (samples_.size() > 1 && samples_[1].time <= time) samples_.pop_front();
}

}  // namespace chasles
