#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <unsupported/Eigen/FFT>

#include <chasles/calibrate/noise/cosine_powers.hpp>
#include <chasles/calibrate/noise/motion_noise.hpp>
#include <chasles/eval/chi2.hpp>

namespace chasles {
namespace {

constexpr double kLowest = 0.2, kHighest = 0.3;  // of the rate
constexpr double kLeastRate = 64;                // [Hz]: at lower ones the band is that of motions
constexpr std::size_t kFewestWindows = 5;
constexpr double kQuiet = 0.1;
// Of Hann's taper the powers of neighbouring frequencies are correlated by (2/3)^2 and (1/6)^2.
constexpr double kCorrelated = 1 + 2 * (4.0 / 9 + 1.0 / 36);

std::size_t window_samples(double period) {
  return smooth_length(static_cast<std::size_t>(std::round(1 / period)));
}

// The first and the last frequency of the band, in a window of n samples.
std::size_t first_bin(std::size_t n) {
  return static_cast<std::size_t>(std::ceil(kLowest * static_cast<double>(n)));
}
std::size_t last_bin(std::size_t n) {
  return static_cast<std::size_t>(std::floor(kHighest * static_cast<double>(n)));
}

// The mean power of a window in the band [unit^2/Hz].
double band_power(std::span<const double> x, double period) {
  const std::size_t n = x.size();
  std::vector<std::complex<double>> tapered(n), spectrum;
  double mean = 0, weights = 0;
  for (const double value : x) mean += value / static_cast<double>(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
    const double weight = std::sin(angle) * std::sin(angle);
    tapered[i] = weight * (x[i] - mean);
    weights += weight * weight;
  }
  Eigen::FFT<double> transform;
  transform.fwd(spectrum, tapered);
  double sum = 0;
  for (std::size_t k = first_bin(n); k <= last_bin(n); ++k) sum += std::norm(spectrum[k]);
  return sum * period / (weights * static_cast<double>(last_bin(n) - first_bin(n) + 1));
}

MotionNoise noise_of(std::vector<double> powers, double dof) {
  const auto n = static_cast<double>(powers.size());
  double mean = 0, variance = 0;
  for (const double power : powers) mean += power / n;
  for (const double power : powers) variance += (power - mean) * (power - mean) / (n - 1);
  const auto quiet = powers.begin() + static_cast<std::ptrdiff_t>(kQuiet * n);
  std::ranges::nth_element(powers, quiet);
  return {.density = std::sqrt(mean),
          .relative_sigma = mean > 0 ? std::sqrt(variance / n) / (2 * mean) : 0,
          .quietest = std::sqrt(std::min(mean, *quiet * dof / chi2_quantile(kQuiet, dof)))};
}

}  // namespace

std::optional<MotionBand> motion_noise(std::span<const EvenSpan> spans) {
  std::array<std::vector<double>, kImuSignals> powers;
  MotionBand band;
  double dof = 0;
  for (const EvenSpan& span : spans) {
    if (span.period * kLeastRate > 1) continue;
    const std::size_t n = window_samples(span.period);
    for (std::size_t from = 0; from + n <= span.count(); from += n) {
      for (std::size_t i = 0; i < kImuSignals; ++i) {
        powers[i].push_back(band_power(std::span(span.signals[i]).subspan(from, n), span.period));
      }
      band.seconds += span.period * static_cast<double>(n);
      band.lowest = kLowest / span.period;
      band.highest = kHighest / span.period;
      dof = 2 * static_cast<double>(last_bin(n) - first_bin(n) + 1) / kCorrelated;
    }
  }
  if (powers[0].size() < kFewestWindows) return std::nullopt;
  for (std::size_t i = 0; i < kImuSignals; ++i) band.signals[i] = noise_of(powers[i], dof);
  return band;
}

}  // namespace chasles
