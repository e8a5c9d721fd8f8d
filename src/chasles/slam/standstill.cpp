#include <cmath>
#include <vector>

#include <chasles/slam/rest_conditions.hpp>
#include <chasles/slam/standstill.hpp>

namespace chasles {
namespace {

constexpr double kWindow = 0.5;  // [s]

// A mean may leave that of the rest's beginning by so many deviations of both, and by what biases
// and a floor that is not quite firm may add.
constexpr double kDeviations = 4;
constexpr double kForceReach = 0.02;  // [m/s^2]
constexpr double kRateReach = 0.002;  // [rad/s]

}  // namespace

Standstill::Standstill(const ImuNoise& noise, std::size_t cameras, double pixel_sigma)
    : noise_(noise), cameras_(cameras), pixel_sigma_(pixel_sigma) {
  thresholds_.rest_window = kWindow;
}

void Standstill::add(const ImuSample& sample) {
  if (!sample.specific_force_imu.allFinite() || !sample.angular_rate_imu.allFinite()) return;
  if (!samples_.empty() && sample.time <= samples_.back().time) return;
  samples_.push_back(sample);
}

bool Standstill::at_rest(const FeatureFrame& frame) {
  frames_.push_back(frame);
  const Time oldest = frame.time - from_seconds(kWindow);
  while (frames_.front().time < oldest) frames_.pop_front();
  while (!samples_.empty() && samples_.front().time < oldest) samples_.pop_front();
  const std::vector<ImuSample> samples(samples_.begin(), samples_.end());
  const std::vector<FeatureFrame> frames(frames_.begin(), frames_.end());
  const auto conditions =
      rest_conditions(samples, frames, cameras_, noise_, pixel_sigma_, thresholds_);
  const bool blind = !conditions.back().met && conditions.back().name == kTracks;
  if (!all_met(conditions) && !(began_ && blind)) {
    began_.reset();
    return false;
  }
  const RestMeans now = rest_means(samples, noise_);
  if (!began_) began_ = now;
  if (!quiet(now)) began_.reset();
  return began_.has_value();
}

bool Standstill::quiet(const RestMeans& now) const {
  const double root_seconds = std::sqrt(now.seconds / 2);
  const double force =
      kForceReach + kDeviations * noise_.accelerometer_noise_density / root_seconds;
  const double rate = kRateReach + kDeviations * noise_.gyroscope_noise_density / root_seconds;
  return (now.specific_force_imu - began_->specific_force_imu).norm() < force &&
         (now.angular_rate_imu - began_->angular_rate_imu).norm() < rate;
}

}  // namespace chasles
