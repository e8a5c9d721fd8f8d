#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <chasles/imu/imu_buffer.hpp>

namespace chasles {
namespace {

// Assumed sigma of the unmeasured excess, as a fraction of the sensor's range.
constexpr double kMissed = 0.5;
// The line through a gap of T misses T^2 / (2 kSteady^2) of the signal's spread, until it misses
// all of it: a body that moves with 1 to 2 Hz.
constexpr double kSteady = 0.28;  // [s]
// Time constant of the spread, which a gap at the beginning of a motion finds small.
constexpr double kRemembered = 1;  // [s]
// Beyond this time, a saturated sensor has no usable neighbours.
constexpr Time kLongestBridge = std::chrono::seconds(1);

// Position of the middle of [start, end] between the two samples, 0 to 1.
double middle_between(const ImuSample& before, const ImuSample& after, Time start, Time end) {
  const double at = (to_seconds(start - before.time) + to_seconds(end - before.time)) / 2;
  return at / to_seconds(after.time - before.time);
}

}  // namespace

void ImuBuffer::Spread::note(const Eigen::Vector3d& value, double weight) {
  const Eigen::Vector3d difference = value - mean;
  mean += weight * difference;
  variance += weight * ((1 - weight) * difference.cwiseAbs2() - variance);
}

double ImuBuffer::Spread::of_bridge(double T) const {
  return std::min(1.0, T * T / (2 * kSteady * kSteady)) * std::sqrt(variance.maxCoeff());
}

bool ImuBuffer::Sensor::saturated(const ImuSample& sample) const {
  return sample.*clipped || (sample.*value).cwiseAbs().maxCoeff() >= range;
}

// On the straight line through two samples of instants: the mean over [start, end].
ImuSample ImuBuffer::value_between(const ImuSample& before, const ImuSample& after, Time start,
                                   Time end) const {
  const double x = middle_between(before, after, start, end);
  ImuSample value = after;
  value.time = end;
  for (const Sensor& sensor : {accelerometer_, gyroscope_}) {
    if (!sensor.of_instant) continue;
    value.*(sensor.value) = (1 - x) * before.*(sensor.value) + x * after.*(sensor.value);
  }
  return value;
}

bool ImuBuffer::add(const ImuSample& sample) {
  if (options_.screened) {
    keep(sample);
    return true;
  }
  const auto dropped = [this] {
    const SampleScreen::Counts& c = screen_.counts();
    return c.not_finite + c.not_later + c.zero + c.frozen + c.interpolated;
  };
  const int before = dropped();
  for (const ImuSample& released : screen_.add(sample)) keep(released);
  return dropped() == before;
}

ImuBuffer::Counts ImuBuffer::counts() const {
  Counts counts = counts_;
  counts.note(screen_.counts());
  return counts;
}

void ImuBuffer::Counts::note(const SampleScreen::Counts& left_out) {
  not_finite = left_out.not_finite;
  not_later = left_out.not_later;
  zero = left_out.zero;
  spikes = left_out.spikes;
  frozen = left_out.frozen;
  interpolated = left_out.interpolated;
}

void ImuBuffer::keep(const ImuSample& sample) {
  if (!samples_.empty() && to_seconds(sample.time - samples_.back().time) > options_.max_interval) {
    ++counts_.gaps;
  }
  if (accelerometer_.saturated(sample) || gyroscope_.saturated(sample)) ++counts_.saturated;
  ++counts_.used;
  // The first sample is the mean.
  const double since = samples_.empty()
                           ? 1e9
                           : std::min(to_seconds(sample.time - samples_.back().time), kRemembered);
  const double weight = 1 - std::exp(-since / kRemembered);
  force_.note(sample.specific_force_imu, weight);
  rate_.note(sample.angular_rate_imu, weight);
  samples_.push_back(sample);
  if (options_.vibration_noise > 0) note_vibration(sample);
}

void ImuBuffer::note_vibration(const ImuSample& sample) {
  AddedNoise added = vibration_.add(
      sample, {.force = accelerometer_.saturated(sample), .rate = gyroscope_.saturated(sample)});
  added.accelerometer *= std::sqrt(options_.vibration_noise);
  added.gyroscope *= std::sqrt(options_.vibration_noise);
  added_.push_back(added);
}

AddedNoise ImuBuffer::added_at(const Position& after) const {
  if (added_.empty()) return {};
  const auto i = static_cast<std::size_t>(after - samples_.begin());
  return added_[std::min(i, added_.size() - 1)];
}

std::vector<ImuInterval> ImuBuffer::between(Time from, Time to) {
  std::vector<ImuInterval> result;
  between(from, to, result);
  return result;
}

void ImuBuffer::between(Time from, Time to, std::vector<ImuInterval>& result) {
  result.clear();
  if (samples_.empty() || to <= from) return;
  if (from < samples_.front().time || to > samples_.back().time) ++counts_.extrapolated;
  auto after = std::ranges::upper_bound(std::as_const(samples_), from, {}, &ImuSample::time);
  for (Time start = from; start < to;) {
    const Time end = after == samples_.end() ? to : std::min(to, after->time);
    result.push_back(interval(start, end, after));
    start = end;
    if (after != samples_.end() && after->time == end) ++after;
  }
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
      value = value_between(before, *after, start, end);
      unmeasured = after->time - before.time;
    }
  }
  const Guess force = bridge(accelerometer_, start, end, after, value.specific_force_imu);
  const Guess rate = bridge(gyroscope_, start, end, after, value.angular_rate_imu);
  const double T = to_seconds(unmeasured);
  const bool gap = T > options_.max_interval;
  const auto density = [&](const Guess& guess, const Spread& spread, double added) {
    const double bridged = gap ? std::hypot(guess.extra_density, spread.of_bridge(T) * std::sqrt(T))
                               : guess.extra_density;
    return added > 0 ? std::hypot(bridged, added) : bridged;
  };
  const AddedNoise added = added_at(after);
  return {.tau = to_seconds(end - start),
          .specific_force_imu = force.mean,
          .angular_rate_imu = rate.mean,
          .noise_scale = std::max(1.0, T / options_.max_interval),
          .accelerometer_extra_density = density(force, force_, added.accelerometer),
          .gyroscope_extra_density = density(rate, rate_, added.gyroscope)};
}

bool ImuBuffer::depends_on_saturated(const Sensor& sensor, const Position& after) const {
  if (after != samples_.end() && sensor.saturated(*after)) return true;
  const bool before = after == samples_.end() || sensor.of_instant;
  return before && after != samples_.begin() && sensor.saturated(*std::prev(after));
}

ImuBuffer::Guess ImuBuffer::bridge(const Sensor& sensor, Time start, Time end,
                                   const Position& after, const Eigen::Vector3d& mean) const {
  if (counts_.saturated == 0 || !depends_on_saturated(sensor, after)) return {.mean = mean};
  const auto good = [&sensor](const ImuSample& sample) { return !sensor.saturated(sample); };
  const auto before = std::find_if(std::make_reverse_iterator(after), samples_.rend(), good);
  const auto later = std::find_if(after, samples_.end(), good);
  const bool known_before = before != samples_.rend(), known_later = later != samples_.end();
  const Time begin = known_before ? before->time : std::min(start, samples_.front().time);
  const Time until = known_later ? later->time : std::max(end, samples_.back().time);
  const double root = std::sqrt(to_seconds(until - begin));
  if (!known_before && !known_later) return {.mean = mean, .extra_density = sensor.range * root};
  const ImuSample& first = known_before ? *before : *later;
  const ImuSample& second = known_later ? *later : *before;
  const double x = first.time < second.time ? middle_between(first, second, start, end) : 0;
  const Eigen::Vector3d line = (1 - x) * first.*(sensor.value) + x * second.*(sensor.value);
  double seen = (mean - line).lpNorm<Eigen::Infinity>();
  for (auto s = before.base(); s != later; ++s) {
    seen = std::max(seen, ((*s).*(sensor.value) - line).lpNorm<Eigen::Infinity>());
  }
  return {.mean = line, .extra_density = (kMissed * sensor.range + seen) * root};
}

std::optional<ImuSample> ImuBuffer::at(Time time) const {
  if (samples_.empty()) return std::nullopt;
  const auto after = std::ranges::lower_bound(samples_, time, {}, &ImuSample::time);
  if (after == samples_.end()) return samples_.back();
  if (after == samples_.begin()) return *after;
  return value_between(*std::prev(after), *after, time, time);
}

std::optional<Time> ImuBuffer::latest() const {
  if (samples_.empty()) return std::nullopt;
  return samples_.back().time;
}

void ImuBuffer::drop_before(Time time) {
  const auto good = [this](const ImuSample& sample) {
    return !accelerometer_.saturated(sample) && !gyroscope_.saturated(sample);
  };
  auto first = std::ranges::upper_bound(std::as_const(samples_), time, {}, &ImuSample::time);
  if (first != samples_.begin()) --first;
  // The bridge starts at the last unsaturated sample before that.
  while (first != samples_.begin() && !good(*first) && time - first->time <= kLongestBridge) {
    --first;
  }
  if (!added_.empty()) added_.erase(added_.begin(), added_.begin() + (first - samples_.begin()));
  samples_.erase(samples_.begin(), first);
}

}  // namespace chasles
