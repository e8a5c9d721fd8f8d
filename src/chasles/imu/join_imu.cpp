#include <cmath>

#include <chasles/imu/join_imu.hpp>

namespace chasles {
namespace {

std::size_t left_out(const SampleScreen& screen) {
  const SampleScreen::Counts& c = screen.counts();
  return static_cast<std::size_t>(c.not_finite + c.not_later + c.zero + c.spikes + c.frozen +
                                  c.interpolated);
}

// The autocorrelation of linearly interpolated white noise at a lag of x periods: the cubic
// B-spline.
double interpolated_correlation(double x) {
  if (x >= 2) return 0;
  return x >= 1 ? std::pow(2 - x, 3) / 6 : 2.0 / 3 - x * x * (1 - x / 2);
}

}  // namespace

std::vector<ImuSample> ImuJoiner::add_force(const AxesSample& force) {
  ++counts_.forces;
  for (const ImuSample& measured :
       screen_.add({.time = force.time, .specific_force_imu = force.value})) {
    const Eigen::Vector3d& value = measured.specific_force_imu;
    const bool clipped = value.cwiseAbs().maxCoeff() >= range_.accelerometer;
    forces_.push_back({.time = measured.time, .value = gyro_R_accel_ * value, .clipped = clipped});
  }
  std::vector<ImuSample> joined = join();
  while (forces_.size() > kMostWaiting) {
    forces_.pop_front();
    ++counts_.dropped_forces;
  }
  return joined;
}

std::vector<ImuSample> ImuJoiner::add_rate(const AxesSample& rate) {
  ++counts_.rates;
  if (!rate.value.allFinite()) {
    ++counts_.unknown_rates;
    return {};
  }
  if (last_rate_ && rate.time <= *last_rate_) {
    ++counts_.late_rates;
    return {};
  }
  last_rate_ = rate.time;
  rates_.push_back(rate);
  std::vector<ImuSample> joined = join();
  while (rates_.size() > kMostWaiting) {
    rates_.pop_front();
    ++counts_.dropped_rates;
  }
  return joined;
}

// A gyroscope sample is decided by an accelerometer sample that is not earlier.
std::vector<ImuSample> ImuJoiner::join() {
  std::vector<ImuSample> joined;
  while (!rates_.empty() && !forces_.empty() && rates_.front().time <= forces_.back().time) {
    join_one(rates_.front(), joined);
    rates_.pop_front();
  }
  return joined;
}

void ImuJoiner::join_one(const AxesSample& rate, std::vector<ImuSample>& joined) {
  while (forces_.size() > 1 && forces_[1].time <= rate.time) forces_.pop_front();
  const Force& before = forces_.front();
  if (rate.time < before.time) {
    ++counts_.before_forces;
    return;
  }
  // At the time of an accelerometer sample nothing is interpolated.
  const bool at_one = rate.time == before.time;
  const Force& after = at_one ? before : forces_[1];
  if (after.time - before.time > kLongestInterval) {
    ++counts_.in_gaps;
    return;
  }
  const Time interval = after.time - before.time;
  const double f = at_one ? 0 : to_seconds(rate.time - before.time) / to_seconds(interval);
  joined.push_back({.time = rate.time,
                    .specific_force_imu = (1 - f) * before.value + f * after.value,
                    .angular_rate_imu = rate.value,
                    .force_clipped = before.clipped || after.clipped});
  ++counts_.joined;
}

void ImuJoiner::restart_forces() {
  screened_before_ += left_out(screen_);
  screen_ = SampleScreen(range_);
  forces_.clear();
}

void ImuJoiner::restart_rates() {
  rates_.clear();
  last_rate_.reset();
}

ImuJoiner::Counts ImuJoiner::counts() const {
  Counts counts = counts_;
  counts.not_measured = screened_before_ + left_out(screen_);
  return counts;
}

double turned_range(double range, const Eigen::Matrix3d& R) {
  if (R.isIdentity(1e-9) || !std::isfinite(range)) return range;
  return range * R.cwiseAbs().rowwise().sum().maxCoeff();
}

double interpolated_noise(double ratio) {
  double sum = interpolated_correlation(0);
  for (int k = 1; k * ratio < 2; ++k) sum += 2 * interpolated_correlation(k * ratio);
  return ratio * sum;
}

}  // namespace chasles
