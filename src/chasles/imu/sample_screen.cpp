#include <algorithm>
#include <cmath>

#include <chasles/imu/sample_screen.hpp>
#include <chasles/lie/se3.hpp>

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
// The change of the change over the change: 1.7 for white noise, and above 0.35 for one of its two
// sensors in all recordings of EuRoC, TUM-VI and KITTI. A motion of 3 Hz at 100 Hz has 0.2.
constexpr double kOfNoise = 0.3;

// Numbers on a line differ from it by their rounding, to six digits or to 32 bits, and by that of
// the times, a share of what they change. The noise of the best sensors is ten times as large.
constexpr double kRounding = 2e-6;
constexpr double kRoundingOfTimes = 0.003;
constexpr double kLeastChange = 50 * kRounding;
constexpr int kByChance = 2;  // samples in a row that are on a line, of any sensor
constexpr std::size_t kFewOnLine = 10;

Vector6d numbers(const ImuSample& sample) {
  return (Vector6d() << sample.specific_force_imu, sample.angular_rate_imu).finished();
}

// Whether c lies where the line through a and b leads. Where a is far away, a slow curve is no
// line.
bool is_on_line(const ImuSample& a, const ImuSample& b, const ImuSample& c) {
  constexpr double kMostAhead = 3;  // intervals
  const double ahead = to_seconds(c.time - b.time) / to_seconds(b.time - a.time);
  if (ahead > kMostAhead) return false;
  const Vector6d at_b = numbers(b), change = ahead * (at_b - numbers(a));
  const Vector6d difference = numbers(c) - (at_b + change);
  const Vector6d rounding = kRounding * at_b.cwiseAbs().cwiseMax(1);
  const Vector6d most = (1 + 2 * ahead) * rounding + kRoundingOfTimes * change.cwiseAbs();
  return (difference.cwiseAbs().array() <= most.array()).all();
}

// A line on which the numbers of one sensor hardly change shows nothing.
bool changes(const ImuSample& a, const ImuSample& b) {
  const auto change = [&](const Eigen::Vector3d ImuSample::*of_sensor) {
    return (b.*of_sensor - a.*of_sensor).cwiseAbs().maxCoeff();
  };
  return std::min(change(&ImuSample::specific_force_imu), change(&ImuSample::angular_rate_imu)) >
         kLeastChange;
}

bool same_numbers(const ImuSample& a, const ImuSample& b) {
  return a.specific_force_imu == b.specific_force_imu && a.angular_rate_imu == b.angular_rate_imu;
}

}  // namespace

void SampleScreen::Change::note(const Eigen::Vector3d& change) {
  ++count;
  const double weight = 1 / std::min<double>(count, kMemory);
  mean += weight * (change.norm() - mean);
  const bool differs = (change - last).norm() > kOfNoise * change.norm();
  noisy += weight * ((differs ? 1 : 0) - noisy);
  last = change;
}

bool SampleScreen::Change::is_noise() const { return noisy > 0.5; }

double SampleScreen::Change::unusual(double magnitude, double least) const {
  return count < kEnough ? 0 : magnitude / std::max(least, kTimesUsual * mean);
}

// A number far beyond the range is no measurement.
bool SampleScreen::at_limit(const ImuSample& sample) const {
  const auto reaches = [](const Eigen::Vector3d& value, double range) {
    const double largest = value.cwiseAbs().maxCoeff();
    return largest >= range && largest <= 1.5 * range;
  };
  return sample.force_clipped || sample.rate_clipped ||
         reaches(sample.specific_force_imu, range_.accelerometer) ||
         reaches(sample.angular_rate_imu, range_.gyroscope);
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
  const bool noisy = different_ >= kNoisy && (force_.is_noise() || rate_.is_noise());
  if (!noisy || at_limit(sample)) return Repeat::kNone;
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
    force_.note(sample.specific_force_imu - last_->specific_force_imu);
    rate_.note(sample.angular_rate_imu - last_->angular_rate_imu);
  }
  last_ = sample;
  released_.push_back(sample);
}

void SampleScreen::check_for_spike(const ImuSample& sample) {
  if (suspect_) {
    if (unusual_change(*last_, sample) < unusual_change(*suspect_, sample)) {
      ++counts_.spikes;
    } else {
      release(*suspect_);
    }
    suspect_.reset();
  }
  if (last_ && !at_limit(sample) && unusual_change(*last_, sample) > 1) {
    suspect_ = sample;
  } else {
    release(sample);
  }
}

void SampleScreen::leave_line() {
  for (const ImuSample& sample : line_.held) check_for_spike(sample);
  line_.held.clear();
  line_.samples = 0;
  line_.interpolated = false;
}

// A recording may begin with a line: nothing is known of its sensor then.
void SampleScreen::follow_line(const ImuSample& sample) {
  std::vector<ImuSample>& last = line_.last;
  const bool known = force_.count >= kEnough;
  const bool may_be = !known || force_.is_noise() || rate_.is_noise();
  const bool on_line = last.size() == 2 && may_be &&
                       is_on_line(line_.samples > 0 ? line_.first : last[0], last[1], sample);
  if (!on_line) leave_line();
  if (on_line && ++line_.samples == 1) line_.first = last[0];
  if (last.size() == 2) last.erase(last.begin());
  last.push_back(sample);
  const bool may_wait = line_.samples > kByChance && changes(line_.first, sample);
  if (line_.held.empty() && !may_wait) {  // none overtakes one that waits
    check_for_spike(sample);
    return;
  }
  if (line_.interpolated) {
    ++counts_.interpolated;
    line_.held.back() = sample;
    return;
  }
  line_.held.push_back(sample);
  line_.interpolated =
      line_.held.size() >= kFewOnLine && sample.time - line_.first.time > kLongestRepeat;
  if (!line_.interpolated) return;
  counts_.interpolated += static_cast<int>(line_.held.size()) - 1;
  line_.held = {sample};  // the last on the line may be a measurement again
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
      leave_line();
      held_.push_back(sample);
      break;
    case Repeat::kFrozen:
      counts_.frozen += static_cast<int>(held_.size()) + 1;
      held_.clear();
      break;
    case Repeat::kNone:
      for (const ImuSample& repeat : held_) check_for_spike(repeat);
      held_.clear();
      follow_line(sample);
      break;
  }
  return released_;
}

}  // namespace chasles
