#include <algorithm>
#include <cmath>
#include <vector>

#include <chasles/imu/signal_noise.hpp>

namespace chasles {
namespace {

constexpr double kNormalMad = 1.4826;  // sigma of a normal distribution / median |x|

double mean_square_difference(std::span<const double> x, std::size_t lag) {
  double sum = 0;
  for (std::size_t i = lag; i < x.size(); ++i) sum += (x[i] - x[i - lag]) * (x[i] - x[i - lag]);
  return x.size() > lag ? sum / static_cast<double>(x.size() - lag) : 0;
}

double square(double x) { return x * x; }

}  // namespace

double robust_sigma(std::vector<double> x) {
  if (x.empty()) return 0;
  for (double& value : x) value = std::abs(value);
  const auto middle = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), middle, x.end());
  return kNormalMad * *middle;
}

SignalNoise measure_signal(std::span<const double> samples, double period) {
  if (samples.size() < 4 || !(period > 0)) return {};
  std::vector<double> first, second;
  for (std::size_t i = 2; i < samples.size(); ++i) {
    first.push_back(samples[i] - samples[i - 1]);
    second.push_back(samples[i] - 2 * samples[i - 1] + samples[i - 2]);
  }
  const double white2 = (square(robust_sigma(second)) - 2 * square(robust_sigma(first))) / 2;
  const double one_step = mean_square_difference(samples, 1);
  double walk2 = 0;
  for (const double seconds : {0.25, 0.5, 1.0}) {
    const auto lag = static_cast<std::size_t>(std::max(2.0, std::round(seconds / period)));
    const double growth = mean_square_difference(samples, lag) - one_step;
    if (seconds < 1 && growth < 0.5 * one_step) continue;
    walk2 = std::max(walk2, growth / (static_cast<double>(lag - 1) * period));
  }
  return {.white = std::sqrt(std::max(0.0, white2)), .walk = std::sqrt(walk2)};
}

std::array<SignalNoise, 6> measure_axes(std::span<const BodyVelocity> velocities) {
  std::array<SignalNoise, 6> result;
  if (velocities.size() < 2) return result;
  const double period = to_seconds(velocities.back().time - velocities.front().time) /
                        static_cast<double>(velocities.size() - 1);
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    std::vector<double> samples;
    for (const BodyVelocity& u : velocities) {
      samples.push_back(axis < 3 ? u.angular_imu[axis] : u.linear_imu[axis - 3]);
    }
    result[static_cast<std::size_t>(axis)] = measure_signal(samples, period);
  }
  return result;
}

}  // namespace chasles
