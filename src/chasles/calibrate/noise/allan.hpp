#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace chasles {

/// The power of noise in three parts, in continuous time, by the conventions of IEEE 952: the
/// two-sided spectral density at the frequency f is N^2 + B^2 / (2 pi f) + K^2 / (2 pi f)^2.
struct NoisePower {
  double white = 0;        ///< N^2 [unit^2 s]
  double instability = 0;  ///< B^2 [unit^2]
  double walk = 0;         ///< K^2 [unit^2 / s]
};

/// Running sums of samples about their mean, from 0 to the whole: one more than there are samples.
std::vector<double> running_sums(std::span<const double> samples);

/// Sum of the squared differences of successive means of m samples, at all overlapping places.
struct AllanSum {
  double squares = 0;
  std::size_t differences = 0;
};

/// The Allan variance of samples is squares / (2 differences), with m averaged samples (D. W. Allan
/// 1966; overlapping: NIST SP 1065, 5.2.4). No differences for m = 0 or fewer than 2 m samples.
/// `sums`: running_sums() of them.
AllanSum allan_sum(std::span<const double> sums, std::size_t m);

/// Whole numbers from 1 to at most `most`, eight in each factor of ten where they are that dense.
std::vector<std::size_t> allan_factors(std::size_t most);

/// The Allan variance that this noise has at tau = m period: N^2/tau + (2 ln 2/pi) B^2 +
/// K^2 (tau/3 + period^2/(6 tau)). The walk is one of samples, whose last term is small.
double allan_variance(const NoisePower& power, std::size_t m, double period);

/// The equivalent degrees of freedom of an overlapping estimate of the Allan variance from one span
/// of `samples`, for Gaussian noise of this power: 2 E^2 / Var = M / (1 + 2 sum (1 - k/M) r_k^2),
/// with M differences and r_k the correlation of two that are k samples apart. Zero without
/// differences.
double allan_degrees_of_freedom(const NoisePower& power, std::size_t m, double period,
                                std::size_t samples);

}  // namespace chasles
