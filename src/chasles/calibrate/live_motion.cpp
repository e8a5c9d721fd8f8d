#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/live_motion.hpp>
#include <chasles/recording/imu_table.hpp>
#include <chasles/recording/uncalibrated.hpp>

namespace chasles {
namespace {

constexpr double kLeastTurning = 0.3;  // root mean square of the rate about an axis [rad/s]
constexpr double kLeastShaking = 0.5;  // of the specific force about its mean [m/s^2]

Eigen::Vector3d mean_of(std::span<const ImuSample> samples, Eigen::Vector3d ImuSample::*part) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : samples) sum += sample.*part;
  return sum / static_cast<double>(samples.size());
}

}  // namespace

std::vector<std::string> missing_motion(std::span<const ImuSample> samples,
                                        const Eigen::Vector3d& gyroscope_bias) {
  if (samples.empty()) return {};
  Eigen::Vector3d turning = Eigen::Vector3d::Zero(), force = turning;
  const Eigen::Vector3d mean = mean_of(samples, &ImuSample::specific_force_imu);
  for (const ImuSample& sample : samples) {
    turning += (sample.angular_rate_imu - gyroscope_bias).cwiseAbs2();
    force += (sample.specific_force_imu - mean).cwiseAbs2();
  }
  const auto count = static_cast<double>(samples.size());
  std::vector<std::string> missing;
  constexpr std::array kAxes = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    const double rate = std::sqrt(turning[i] / count), shaking = std::sqrt(force[i] / count);
    const char* axis = kAxes[static_cast<std::size_t>(i)];
    if (rate < kLeastTurning) {
      missing.push_back(fmt::format(
          "the rig turns by {:.2f} rad/s about the IMU's {} axis, in the mean: turn it there by "
          "{:.1f} rad/s or more",
          rate, axis, kLeastTurning));
    }
    if (shaking < kLeastShaking) {
      missing.push_back(fmt::format(
          "the force along the IMU's {} axis changes by {:.2f} m/s^2, in the mean: tilt or shake "
          "the rig until it is {:.1f} m/s^2 or more",
          axis, shaking, kLeastShaking));
    }
  }
  return missing;
}

void LiveMotion::poll() {
  try {
    const std::optional<std::filesystem::path> table = imu_table_of(folder_);
    const std::optional<FileState> now = table ? FileState::of(*table) : std::nullopt;
    if (!now || *now == state_) return;
    samples_ = read_whole_rows(*table);
    state_ = *now;
  } catch (const InputError&) {  // it has no whole row yet
  }
}

std::vector<std::string> LiveMotion::missing(Time first, Time last) const {
  if (samples_.empty()) return {"there are no samples of an IMU yet"};
  const auto at = [&](Time time) {
    return std::ranges::lower_bound(samples_, time, {}, &ImuSample::time);
  };
  std::span<const ImuSample> during(at(first), at(last));
  if (during.empty()) during = samples_;
  return missing_motion(during, mean_of(during, &ImuSample::angular_rate_imu));
}

}  // namespace chasles
