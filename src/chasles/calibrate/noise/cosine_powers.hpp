#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <chasles/calibrate/noise/allan.hpp>

namespace chasles {

/// Coefficients of a signal's cosine transform at nearly the same frequency.
struct PowerBand {
  double frequency = 0;  ///< mean [Hz]
  double power = 0;      ///< mean square of the coefficients times the period [unit^2 / Hz]
  double count = 0;      ///< of the coefficients
  NoisePower parts;      ///< of a coefficient's variance: what a part of power 1 contributes
};

/// The squares of the cosine transform (DCT-II, orthonormal, without the mean) of samples at even
/// times, up to a frequency [Hz], in narrow bands: 2 % wide, or one coefficient.
///
/// The transform makes the samples' likelihood a product: of white noise on a random walk, with an
/// unknown bias at the beginning, the coefficients j = 1, ..., n - 1 are independent, with the
/// variances (N^2 + K^2 / w_j^2) / period, w_j = 2 sin(pi j / (2 n)) / period. That is exact,
/// because the cosines are the singular vectors of the difference operator. The instability is
/// modelled as B^2 / w_j. Trailing samples, at most a few in a hundred, are left out so that n has
/// no prime factor above 5. No bands for fewer than 16 samples.
std::vector<PowerBand> cosine_powers(std::span<const double> samples, double period,
                                     double highest);

/// The largest whole number up to n (above 0) without a prime factor above 5.
std::size_t smooth_length(std::size_t n);

/// Orthonormal DCT-II of a signal without its mean; coefficient 0 is 0 (Makhoul 1980).
std::vector<double> cosine_transform(std::span<const double> samples);

}  // namespace chasles
