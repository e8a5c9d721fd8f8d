#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

#include <unsupported/Eigen/FFT>

#include <chasles/calibrate/noise/cosine_powers.hpp>

namespace chasles {
namespace {

constexpr double kBandWidth = 0.02;
constexpr std::size_t kFewestSamples = 16;

bool is_smooth(std::size_t n) {
  for (const std::size_t prime : {2, 3, 5}) {
    while (n % prime == 0) n /= prime;
  }
  return n == 1;
}

void divide(PowerBand& band) {
  band.frequency /= band.count;
  band.power /= band.count;
  band.parts.white /= band.count;
  band.parts.instability /= band.count;
  band.parts.walk /= band.count;
}

}  // namespace

std::size_t smooth_length(std::size_t n) {
  while (!is_smooth(n)) --n;
  return n;
}

std::vector<double> cosine_transform(std::span<const double> samples) {
  const std::size_t n = samples.size();
  if (n < 2) return std::vector<double>(n, 0.0);  // Eigen's transform has no plan for one sample
  const double mean = std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(n);
  std::vector<std::complex<double>> reordered(n), spectrum;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t place = i % 2 == 0 ? i / 2 : n - 1 - i / 2;
    reordered[place] = samples[i] - mean;
  }
  Eigen::FFT<double> transform;
  transform.fwd(spectrum, reordered);
  std::vector<double> result(n, 0.0);
  const double size = static_cast<double>(n), scale = std::sqrt(2 / size);
  for (std::size_t j = 1; j < n; ++j) {
    const double angle = -std::numbers::pi * static_cast<double>(j) / (2 * size);
    result[j] = scale * (spectrum[j] * std::polar(1.0, angle)).real();
  }
  return result;
}

std::vector<PowerBand> cosine_powers(std::span<const double> samples, double period,
                                     double highest) {
  std::vector<PowerBand> bands;
  if (samples.size() < kFewestSamples) return bands;
  const std::size_t n = smooth_length(samples.size());
  const std::vector<double> coefficients = cosine_transform(samples.first(n));
  std::size_t end = 1;  // of the present band
  for (std::size_t j = 1; j < n; ++j) {
    const double angle = std::numbers::pi * static_cast<double>(j) / (2 * static_cast<double>(n));
    const double w = 2 * std::sin(angle) / period;
    const double frequency = angle / (std::numbers::pi * period);
    if (frequency > highest) break;
    if (j == end) {
      if (!bands.empty()) divide(bands.back());
      bands.emplace_back();
      end = j +
            std::max<std::size_t>(1, static_cast<std::size_t>(kBandWidth * static_cast<double>(j)));
    }
    PowerBand& band = bands.back();
    band.frequency += frequency;
    band.power += coefficients[j] * coefficients[j] * period;
    band.count += 1;
    band.parts.white += 1;
    band.parts.instability += 1 / w;
    band.parts.walk += 1 / (w * w);
  }
  if (!bands.empty()) divide(bands.back());
  return bands;
}

}  // namespace chasles
