#pragma once

#include <cstddef>
#include <span>

namespace chasles {

/// Probability that a chi-square variable of `dof` degrees of freedom is at most x: the regularised
/// incomplete gamma function P(dof/2, x/2). Accurate to about 1e-13 (1e-11 above a million
/// degrees). Throws UsageError unless dof is positive; 0 for x <= 0.
double chi2_cdf(double x, double dof);

/// The x with chi2_cdf(x, dof) = probability. Throws UsageError unless 0 <= probability < 1 and
/// dof > 0.
double chi2_quantile(double probability, double dof);

/// An interval of a statistic.
struct Band {
  double low = 0;
  double high = 0;
  bool contains(double x) const { return low <= x && x <= high; }
};

/// The interval that contains the mean of n independent chi-square variables of `dof` degrees of
/// freedom with the given probability, two-sided with equal tails (Bar-Shalom, Li, Kirubarajan
/// 2001, §5.4.2). n = 1 is the interval of one variable. Throws UsageError for n = 0 or probability
/// outside (0, 1).
Band chi2_band(double dof, std::size_t n, double probability = 0.95);

/// The normalised innovation squared of one update and the degrees of freedom of its innovation.
struct Nis {
  double value = 0;
  int dof = 0;
};

/// All innovations of a run.
struct NisSummary {
  std::size_t frames = 0;  ///< updates with at least one degree of freedom
  double dof = 0;          ///< in all
  double per_dof = 0;  ///< sum of NIS over sum of dof: 1 for a consistent filter; 0 without data
  Band band;           ///< 95 % band of per_dof for independent innovations
};

/// Updates without observations (dof 0) do not count.
NisSummary summarize_nis(std::span<const Nis> updates);

}  // namespace chasles
