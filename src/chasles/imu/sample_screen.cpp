#include <algorithm>
#include <cmath>

#include <chasles/imu/sample_screen.hpp>

namespace chasles {
namespace {

// A spike differs from the samples around it by so much at least, and by so many times their usual
// difference. No body turns by 2 rad/s more for one sample; heels and landings reach 50 m/s^2.
constexpr double kLeastRate = 2;    // [rad/s]
constexpr double kLeastForce = 60;  // [m/s^2]
constexpr double kTimesUsual = 20;
constexpr double kMemory = 32;  // samples
constexpr int kEnough = 20;     // differences, before one can be unusual

constexpr Time kLongestRepeat = std::chrono::milliseconds(100);
constexpr int kFewRepeats = 5;
constexpr int kNoisy = 50;  // consecutive different samples
// More than the bias of a gyroscope or an accelerometer at rest.
constexpr double kTurning = 0.02;      // [rad/s]
constexpr double kAccelerating = 0.2;  // [m/s^2]

bool same_numbers(const ImuSample& a, const ImuSample& b) {
  return a.specific_force_imu == b.specific_force_imu && a.angular_rate_imu == b.angular_rate_imu;
}

bool in_motion(const ImuSample& sample) {
  return sample.angular_rate_imu.norm() > kTurning ||
         std::abs(sample.specific_force_imu.norm() - kStandardGravity) > kAccelerating;
}

}  // namespace

void SampleScreen::Change::note(double magnitude) {
  ++count;
  mean += (magnitude - mean) / std::min<double>(count, kMemory);
}

double SampleScreen::Change::unusual(double magnitude, double least) const {
  return count < kEnough ? 0 : magnitude / std::max(least, kTimesUsual * mean);
}

bool SampleScreen::at_limit(const ImuSample& sample) const {
  return sample.force_clipped || sample.rate_clipped ||
         sample.specific_force_imu.cwiseAbs().maxCoeff() >= range_.accelerometer ||
         sample.angular_rate_imu.cwiseAbs().maxCoeff() >= range_.gyroscope;
}

SampleScreen::Repeat SampleScreen::compare(const ImuSample& sample) {
  if (!repeated_ || !same_numbers(sample, *repeated_)) {
    const bool known_as_noisy = repeats_ == 0 || different_ >= kNoisy;
    different_ = known_as_noisy ? different_ + 1 : 0;
    repeats_ = 0;
    repeated_ = sample;
    return Repeat::kNone;
  }
  ++repeats_;
  if (different_ < kNoisy || !in_motion(sample) || at_limit(sample)) return Repeat::kNone;
  const bool long_enough =
      repeats_ >= kFewRepeats && sample.time - repeated_->time > kLongestRepeat;
  return long_enough ? Repeat::kFrozen : Repeat::kMayFreeze;
}

double SampleScreen::unusual_change(const ImuSample& from, const ImuSample& to) const {
  const double force = (to.specific_force_imu - from.specific_force_imu).norm();
  const double rate = (to.angular_rate_imu - from.angular_rate_imu).norm();
  return std::max(force_.unusual(force, kLeastForce), rate_.unusual(rate, kLeastRate));
}

void SampleScreen::release(const ImuSample& sample) {
  if (last_) {
    force_.note((sample.specific_force_imu - last_->specific_force_imu).norm());
    rate_.note((sample.angular_rate_imu - last_->angular_rate_imu).norm());
  }
  last_ = sample;
  released_.push_back(sample);
}

void SampleScreen::check_for_spike(const ImuSample& sample) {
  if (doubtful_) {
    if (unusual_change(*last_, sample) < unusual_change(*doubtful_, sample)) {
      ++counts_.spikes;
    } else {
      release(*doubtful_);
    }
    doubtful_.reset();
  }
  if (last_ && !at_limit(sample) && unusual_change(*last_, sample) > 1) {
    doubtful_ = sample;
  } else {
    release(sample);
  }
}

std::span<const ImuSample> SampleScreen::add(const ImuSample& sample) {
  released_.clear();
  if (!sample.specific_force_imu.allFinite() || !sample.angular_rate_imu.allFinite()) {
    ++counts_.not_finite;
    return {};
  }
  if (newest_ && sample.time <= *newest_) {
    ++counts_.not_later;
    return {};
  }
  newest_ = sample.time;
  if (sample.specific_force_imu.isZero(0) && sample.angular_rate_imu.isZero(0)) {
    ++counts_.zero;
    return {};
  }
  switch (compare(sample)) {
    case Repeat::kMayFreeze:
      held_.push_back(sample);
      break;
    case Repeat::kFrozen:
      counts_.frozen += static_cast<int>(held_.size()) + 1;
      held_.clear();
      break;
    case Repeat::kNone:
      for (const ImuSample& repeat : held_) check_for_spike(repeat);
      held_.clear();
      check_for_spike(sample);
      break;
  }
  return released_;
}

}  // namespace chasles
