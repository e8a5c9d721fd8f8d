#include <cmath>
#include <vector>

#include <chasles/initialise/standstill.hpp>
#include <chasles/initialise/static_conditions.hpp>

namespace chasles {
namespace {

constexpr double kWindow = 0.5;  // [s]

// A mean may differ from that at the beginning by this many standard deviations of both, plus the
// effect of biases and of a floor that yields.
constexpr double kMeanSigmas = 4;
constexpr double kForceReach = 0.02;  // [m/s^2]
constexpr double kRateReach = 0.002;  // [rad/s]

}  // namespace

Standstill::Standstill(const ImuNoise& noise, std::size_t cameras, double pixel_sigma)
    : noise_(noise), cameras_(cameras), pixel_sigma_(pixel_sigma) {
  thresholds_.static_window = kWindow;
}

void Standstill::add(const ImuSample& sample) { samples_.push_back(sample); }

bool Standstill::detected(const FeatureFrame& frame) {
  const Time oldest = frame.time - from_seconds(kWindow);
  const auto is_old = [&](const auto& seen) { return seen.time < oldest; };
  std::erase_if(samples_, is_old);
  frames_.remove_if(is_old);
  if (!frame.pixels.empty()) {
    FeatureFrame& kept = frames_.append();
    kept.time = frame.time;
    kept.pixels = frame.pixels;
  }
  const auto& conditions =
      static_conditions(samples_, frames_, cameras_, noise_, pixel_sigma_, thresholds_, scratch_);
  const bool blind = !conditions.back().met && conditions.back().name == kTracks;
  if (!all_met(conditions) && !(start_ && blind)) {
    start_.reset();
    return false;
  }
  const StandstillMeans now = standstill_means(samples_, noise_);
  if (!start_) start_ = now;
  if (!quiet(now)) start_.reset();
  return start_.has_value();
}

bool Standstill::quiet(const StandstillMeans& now) const {
  const double root_seconds = std::sqrt(now.seconds / 2);
  const double force =
      kForceReach + kMeanSigmas * noise_.accelerometer_noise_density / root_seconds;
  const double rate = kRateReach + kMeanSigmas * noise_.gyroscope_noise_density / root_seconds;
  return (now.specific_force_imu - start_->specific_force_imu).norm() < force &&
         (now.angular_rate_imu - start_->angular_rate_imu).norm() < rate;
}

void zero_velocity_measurements(const State& x, const Clone& start, double seconds,
                                double velocity_sigma, std::array<Measurement, 2>& result) {
  constexpr double kPositionSigma = 0.005, kRotationSigma = 0.001;  // [m], [rad]
  const double rate = 1 / seconds;
  auto& [stays, stopped] = result;
  stays.clear();
  stopped.clear();
  stays.residual.resize(6);
  stays.residual << -so3::log(x.world_T_imu.R * start.world_T_imu.R.transpose()),
      start.world_T_imu.p - x.world_T_imu.p;
  stays.d_core = Matrix6d::Identity();
  stays.clones.push_back({.row = start.row, .d = -Matrix6d::Identity()});
  stays.noise = Matrix6d::Identity() * std::pow(kPositionSigma, 2) * rate;
  stays.noise.topLeftCorner<3, 3>() *= std::pow(kRotationSigma / kPositionSigma, 2);
  stopped.core_column = 6;
  stopped.residual = -*x.v_world;
  stopped.d_core = Eigen::Matrix3d::Identity();
  stopped.noise = Eigen::Matrix3d::Identity() * std::pow(velocity_sigma, 2) * rate;
}

}  // namespace chasles
