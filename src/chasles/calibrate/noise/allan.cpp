#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include <chasles/calibrate/noise/allan.hpp>

namespace chasles {
namespace {

constexpr double kPerFactorOfTen = 8;
constexpr std::size_t kStrides = 64;

// Generalised covariance of the sums of the samples, for parts that each have the power 1. Second
// differences of the sums have ordinary covariances of these.
double sum_covariance(const NoisePower& power, double k, double period) {
  const double k2 = k * k, abs_k = std::abs(k);
  const double flicker = abs_k > 0 ? k2 * std::log(abs_k) / (2 * std::numbers::pi) : 0;
  return -power.white / period * abs_k / 2 + power.instability * flicker +
         power.walk * period * (k2 * abs_k - abs_k) / 12;
}

// Covariance of two differences of means that are k samples apart.
double difference_covariance(const NoisePower& power, std::size_t k, std::size_t m, double period) {
  static constexpr std::array<double, 5> kWeights = {1, -4, 6, -4, 1};
  double sum = 0;
  for (int i = -2; i <= 2; ++i) {
    sum += kWeights[static_cast<std::size_t>(i + 2)] *
           sum_covariance(power, static_cast<double>(k) + i * static_cast<double>(m), period);
  }
  return sum / (static_cast<double>(m) * static_cast<double>(m));
}

}  // namespace

std::vector<double> running_sums(std::span<const double> samples) {
  std::vector<double> sums(samples.size() + 1, 0.0);
  const double mean =
      std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) sums[i + 1] = sums[i] + (samples[i] - mean);
  return sums;
}

AllanSum allan_sum(std::span<const double> sums, std::size_t m) {
  AllanSum result;
  if (m == 0 || sums.size() < 2 * m + 1) return result;
  for (std::size_t i = 0; i + 2 * m < sums.size(); ++i) {
    const double difference =
        (sums[i + 2 * m] - 2 * sums[i + m] + sums[i]) / static_cast<double>(m);
    result.squares += difference * difference;
    ++result.differences;
  }
  return result;
}

std::vector<std::size_t> allan_factors(std::size_t most) {
  std::vector<std::size_t> factors;
  for (int i = 0;; ++i) {
    const double exact = std::pow(10.0, i / kPerFactorOfTen);
    if (exact > static_cast<double>(most) + 0.5) return factors;
    const auto factor = static_cast<std::size_t>(std::round(exact));
    if (factor <= most && (factors.empty() || factors.back() < factor)) factors.push_back(factor);
  }
}

double allan_variance(const NoisePower& power, std::size_t m, double period) {
  const double tau = static_cast<double>(m) * period;
  return power.white / tau + 2 * std::numbers::ln2 / std::numbers::pi * power.instability +
         power.walk * (tau / 3 + period * period / (6 * tau));
}

double allan_degrees_of_freedom(const NoisePower& power, std::size_t m, double period,
                                std::size_t samples) {
  if (m == 0 || samples < 2 * m) return 0;
  const std::size_t differences = samples - 2 * m + 1;
  const double variance = difference_covariance(power, 0, m, period);
  const auto count = static_cast<double>(differences);
  // Beyond this distance only the instability correlates the differences, by less than 1e-4.
  const std::size_t farthest = std::min(8 * m, differences - 1);
  // The correlation changes slowly where m is large: the trapezoidal rule.
  const std::size_t stride = std::max<std::size_t>(1, m / kStrides);
  double sum = (static_cast<double>(stride) - 1) / 2;
  for (std::size_t k = stride; k <= farthest; k += stride) {
    const double correlation = difference_covariance(power, k, m, period) / variance;
    sum += static_cast<double>(stride) * (1 - static_cast<double>(k) / count) * correlation *
           correlation;
  }
  return count / (1 + 2 * sum);
}

}  // namespace chasles
