#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/chi2.hpp>

namespace chasles {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
// Both expansions need a few times sqrt(dof) terms: enough for 1e9 degrees of freedom.
constexpr double kMostTerms = 1e6;

// x^a exp(-x) / Gamma(a+1). For large a the three factors overflow and their logarithms cancel, so
// Stirling's series is divided out analytically there.
double gamma_density(double a, double x) {
  if (a < 10) return std::pow(x, a) * std::exp(-x) / std::tgamma(a + 1);
  const double mu = (x - a) / a;
  const double b = 1 / (a * a);
  const double stirling =
      (1. / 12 - b * (1. / 360 - b * (1. / 1260 - b * (1. / 1680 - b / 1188)))) / a;
  return std::exp(a * (std::log1p(mu) - mu) - stirling) / std::sqrt(2 * std::numbers::pi * a);
}

// P(a, x) by its series, for x < a + 1 (Abramowitz & Stegun 6.5.29).
double lower_series(double a, double x) {
  double term = 1;
  double sum = 1;
  for (double n = 1; n < kMostTerms && term > kEpsilon * sum; ++n) {
    term *= x / (a + n);
    sum += term;
  }
  return sum * gamma_density(a, x);
}

// Q(a, x) by its continued fraction, for x > a + 1 (Abramowitz & Stegun 6.5.31, evaluated with
// Lentz's method).
double upper_fraction(double a, double x) {
  double b = x + 1 - a;
  double c = 1 / std::numeric_limits<double>::min();
  double d = 1 / b;
  double h = d;
  for (double n = 1; n < kMostTerms; ++n) {
    const double numerator = -n * (n - a);
    b += 2;
    d = 1 / (numerator * d + b);
    c = b + numerator / c;
    h *= d * c;
    if (std::abs(d * c - 1) <= 2 * kEpsilon) break;
  }
  return h * a * gamma_density(a, x);
}

struct Tails {
  double lower, upper;
};

// Both tails, so that neither loses precision as a difference from 1.
Tails tails(double x, double dof) {
  if (std::isnan(x)) return {x, x};
  if (!(x > 0)) return {0, 1};
  if (std::isinf(x)) return {1, 0};
  const double a = dof / 2;
  if (x / 2 < a + 1) {
    const double lower = lower_series(a, x / 2);
    return {lower, 1 - lower};
  }
  const double upper = upper_fraction(a, x / 2);
  return {1 - upper, upper};
}

void require_dof(double dof) {
  if (!(dof > 0) || std::isinf(dof)) {
    throw UsageError(
        fmt::format("chi-square: {} degrees of freedom, expected a positive number", dof));
  }
}

}  // namespace

double chi2_cdf(double x, double dof) {
  require_dof(dof);
  return tails(x, dof).lower;
}

double chi2_quantile(double probability, double dof) {
  require_dof(dof);
  if (!(probability >= 0 && probability < 1)) {
    throw UsageError(
        fmt::format("chi-square quantile: probability {}, expected 0 <= p < 1", probability));
  }
  if (probability == 0) return 0;
  double low = 0;
  double high = std::numeric_limits<double>::infinity();
  double x = dof;
  // A Newton step, limited to the bracket that every evaluation narrows.
  for (int i = 0; i < 200; ++i) {
    const Tails at = tails(x, dof);
    const double excess = probability < 0.5 ? at.lower - probability : (1 - probability) - at.upper;
    (excess > 0 ? high : low) = x;
    const double density = dof / (2 * x) * gamma_density(dof / 2, x / 2);
    double next = x - excess / density;
    if (!(next > low && next < high)) next = std::isinf(high) ? 2 * x : (low + high) / 2;
    const bool done = std::abs(next - x) <= 50 * kEpsilon * x;
    x = next;
    if (done) break;
  }
  return x;
}

Band chi2_band(double dof, std::size_t n, double probability) {
  if (n == 0 || !(probability > 0 && probability < 1)) {
    throw UsageError(fmt::format(
        "chi-square band: {} draws and probability {}, expected at least one draw and 0 < p < 1", n,
        probability));
  }
  const auto draws = static_cast<double>(n);
  const double tail = (1 - probability) / 2;
  return {chi2_quantile(tail, draws * dof) / draws, chi2_quantile(1 - tail, draws * dof) / draws};
}

NisSummary summarize_nis(std::span<const Nis> updates) {
  NisSummary summary;
  double sum = 0;
  for (const Nis& update : updates) {
    if (update.dof <= 0) continue;
    ++summary.frames;
    summary.dof += update.dof;
    sum += update.value;
  }
  if (summary.frames == 0) return summary;
  summary.per_dof = sum / summary.dof;
  const Band total = chi2_band(summary.dof, 1);
  summary.band = {total.low / summary.dof, total.high / summary.dof};
  return summary;
}

}  // namespace chasles
