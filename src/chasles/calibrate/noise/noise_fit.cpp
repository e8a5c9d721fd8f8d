#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Dense>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/noise/noise_fit.hpp>
#include <chasles/eval/chi2.hpp>

namespace chasles {
namespace {

constexpr double kShown = 9;           // twice the difference of logarithms of likelihoods: 3 sigma
constexpr double kLimit = 2.7055;      // the same at a one-sided limit of 95 %
constexpr double kLeastFrequency = 1;  // [Hz]
constexpr double kLeastCount = 64;     // coefficients
constexpr double kFewest = 8;          // coefficients
constexpr double kTolerance = 0.02;    // of a power
const double kThirdOfAnOctave = std::cbrt(2.0);
constexpr double kMisfitProbability = 0.9999;
constexpr double kFewestOfThird = 16;  // coefficients of a band whose residual is near to normal
constexpr int kMostSteps = 200;

enum Part { kWhite, kInstability, kWalk };
using Powers = Eigen::Vector3d;
using Free = std::array<bool, 3>;

Powers parts_of(const PowerBand& band) {
  return {band.parts.white, band.parts.instability, band.parts.walk};
}

// The likelihood of some bands.
class Likelihood {
 public:
  explicit Likelihood(std::span<const PowerBand> bands) : bands_(bands) {}

  // Minus twice its logarithm.
  double cost(const Powers& x) const {
    double sum = 0;
    for (const PowerBand& band : bands_) {
      const double v = parts_of(band).dot(x);
      sum += band.count * (std::log(v) + band.power / v);
    }
    return sum;
  }

  Eigen::Matrix3d information(const Powers& x) const {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const PowerBand& band : bands_) {
      const Powers p = parts_of(band);
      const double v = p.dot(x);
      sum += band.count / (2 * v * v) * p * p.transpose();
    }
    return sum;
  }

  Powers gradient(const Powers& x) const {  // of the logarithm
    Powers sum = Powers::Zero();
    for (const PowerBand& band : bands_) {
      const Powers p = parts_of(band);
      const double v = p.dot(x);
      sum += band.count / 2 * (band.power - v) / (v * v) * p;
    }
    return sum;
  }

  // The most likely powers, none negative. Those that are not free stay as they are.
  Powers maximise(Powers x, const Free& free) const;

  // All positive: each part alone would explain the power of some frequencies.
  Powers start() const;

 private:
  std::span<const PowerBand> bands_;
};

Powers Likelihood::start() const {
  Powers x;
  for (int i = 0; i < 3; ++i) {
    double least = std::numeric_limits<double>::infinity();
    double power = 0, part = 0, count = 0;
    for (const PowerBand& band :
         bands_) {  // of groups of some coefficients, the one that allows least
      power += band.count * band.power;
      part += band.count * parts_of(band)[i];
      count += band.count;
      if (count < kFewest) continue;
      least = std::min(least, power / part);
      power = part = count = 0;
    }
    x[i] = least;
  }
  return x;
}

// The step of Fisher's scoring over the powers that may change.
Powers scoring_step(const Likelihood& likelihood, const Powers& x, const Free& free) {
  Eigen::Matrix3d A = likelihood.information(x);
  Powers g = likelihood.gradient(x);
  for (int i = 0; i < 3; ++i) {
    const bool held = !free[static_cast<std::size_t>(i)] || (x[i] <= 0 && g[i] <= 0);
    if (!held) continue;
    A.row(i).setZero();
    A.col(i).setZero();
    A(i, i) = 1;
    g[i] = 0;
  }
  // The units of the three differ by many orders of magnitude.
  const Powers scale = A.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Matrix3d scaled = scale.asDiagonal() * A * scale.asDiagonal();
  const Powers scaled_step = scaled.ldlt().solve(scale.cwiseProduct(g));
  return scale.cwiseProduct(scaled_step);
}

Powers Likelihood::maximise(Powers x, const Free& free) const {
  double now = cost(x);
  for (int i = 0; i < kMostSteps; ++i) {
    const Powers step = scoring_step(*this, x, free);
    double length = 1, next = now;
    Powers candidate = x;
    for (; length > 1e-6; length /= 2) {
      candidate = (x + length * step).cwiseMax(0);
      next = cost(candidate);
      if (std::isfinite(next) && next < now) break;
    }
    if (!(next < now)) return x;
    const bool done = now - next < 1e-9;
    x = candidate;
    now = next;
    if (done) return x;
  }
  return x;
}

// Fits with and without each part that may be missing.
struct Fits {
  Powers all, no_instability, no_walk, white_alone;
};

Fits fit_all(const Likelihood& likelihood) {
  const Powers start = likelihood.start();
  const auto fit = [&](bool instability, bool walk) {
    Powers x = start;
    if (!instability) x[kInstability] = 0;
    if (!walk) x[kWalk] = 0;
    return likelihood.maximise(x, {true, instability, walk});
  };
  return {.all = fit(true, true),
          .no_instability = fit(false, true),
          .no_walk = fit(true, false),
          .white_alone = fit(false, false)};
}

// The root of the largest power of a part whose profile likelihood is not too bad.
double limit_of(const Likelihood& likelihood, const Powers& best, const Free& free, Part part,
                double inflation) {
  Free others = free;
  others[part] = false;
  const double worst = likelihood.cost(best) + kLimit * inflation;
  const auto is_allowed = [&](double power) {
    Powers x = best;
    x[part] = power;
    return likelihood.cost(likelihood.maximise(x, others)) < worst;
  };
  const double unit = 1 / std::sqrt(likelihood.information(best)(part, part));
  double low = best[part], high = best[part] + unit;
  while (is_allowed(high)) {
    low = high;
    high = best[part] + 2 * (high - best[part]);
  }
  constexpr int kBisections = 30;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = (low + high) / 2;
    (is_allowed(middle) ? low : high) = middle;
  }
  return std::sqrt(high);
}

// The bands of each third of an octave, or of more, where that has too few coefficients: the
// measured power over that of the fit, and the number of coefficients.
struct Third {
  double ratio = 0, count = 0;
};

std::vector<Third> thirds_of(std::span<const PowerBand> bands, const Powers& x) {
  std::vector<PowerBand> sorted(bands.begin(), bands.end());
  std::ranges::sort(sorted, {}, &PowerBand::frequency);
  std::vector<Third> thirds;
  double begin = 0;
  for (const PowerBand& band : sorted) {
    const bool full = !thirds.empty() && thirds.back().count >= kFewestOfThird &&
                      band.frequency > begin * kThirdOfAnOctave;
    if (thirds.empty() || full) {
      thirds.emplace_back();
      begin = band.frequency;
    }
    thirds.back().ratio += band.count * band.power / parts_of(band).dot(x);
    thirds.back().count += band.count;
  }
  for (Third& third : thirds) third.ratio /= third.count;
  return thirds;
}

// How well the fit describes the bands: squared residuals of the thirds per degree of freedom.
struct Misfit {
  double value = 1;
  bool significant = false;
};

Misfit misfit_of(std::span<const PowerBand> bands, const Powers& x, int parameters) {
  const std::vector<Third> thirds = thirds_of(bands, x);
  const double dof = std::max(1.0, static_cast<double>(thirds.size()) - parameters);
  double chi2 = 0;
  for (const Third& third : thirds) {
    const double residual = third.ratio - 1;
    chi2 += residual * residual / (2 / third.count + kTolerance * kTolerance);
  }
  return {.value = chi2 / dof, .significant = chi2 > chi2_quantile(kMisfitProbability, dof)};
}

double total_count(std::span<const PowerBand> bands) {
  double sum = 0;
  for (const PowerBand& band : bands) sum += band.count;
  return sum;
}

// How many of the bands the model describes, from the lowest frequency on; `bands` are sorted.
std::size_t white_bands(std::span<const PowerBand> bands) {
  for (std::size_t end = bands.size();;) {
    const Likelihood likelihood(bands.first(end));
    const Powers x = likelihood.maximise(likelihood.start(), {true, true, true});
    if (!misfit_of(bands.first(end), x, 3).significant) return end;
    const double highest = bands[end - 1].frequency / kThirdOfAnOctave;
    std::size_t next = end;
    while (next > 0 && bands[next - 1].frequency > highest) --next;
    if (highest < kLeastFrequency || total_count(bands.first(next)) < kLeastCount) return end;
    end = next;
  }
}

NoiseTerm term_of(double power, double sigma) {
  const double value = std::sqrt(power);
  return {.shown = true,
          .value = value,
          .relative_sigma = sigma / (2 * power),
          .limit = value * std::exp(1.6449 * sigma / (2 * power))};
}

// The covariance of the powers that are free, also of one whose most likely value is 0: that it is
// not known adds to the sigmas of the others.
Eigen::Matrix3d covariance_of(const Likelihood& likelihood, const Powers& x, const Free& free) {
  Eigen::Matrix3d A = likelihood.information(x);
  for (int i = 0; i < 3; ++i) {
    if (free[static_cast<std::size_t>(i)]) continue;
    A.row(i).setZero();
    A.col(i).setZero();
    A(i, i) = 1;
  }
  const Powers scale = A.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Matrix3d scaled = scale.asDiagonal() * A * scale.asDiagonal();
  return scale.asDiagonal() * scaled.inverse() * scale.asDiagonal();
}

NoiseFit fit_of(const Likelihood& likelihood, std::span<const PowerBand> bands) {
  const Fits fits = fit_all(likelihood);
  const auto better = [&](const Powers& with, const Powers& without) {
    return likelihood.cost(without) - likelihood.cost(with);
  };
  const bool instability = better(fits.all, fits.no_instability) > kShown;
  const Powers x = instability ? fits.all : fits.no_instability;
  const bool walk = better(x, instability ? fits.no_walk : fits.white_alone) > kShown;

  NoiseFit fit;
  const Misfit misfit = misfit_of(bands, x, 1 + (instability ? 1 : 0) + (walk ? 1 : 0));
  fit.misfit = misfit.value;
  const double inflation = misfit.significant ? misfit.value : 1;
  const Eigen::Matrix3d P = inflation * covariance_of(likelihood, x, {true, instability, true});
  if (kShown * P(kWhite, kWhite) < x[kWhite] * x[kWhite]) {
    fit.white = term_of(x[kWhite], std::sqrt(P(kWhite, kWhite)));
    fit.covariance(0, 0) = fit.white.relative_sigma * fit.white.relative_sigma;
  } else {  // slow noise covers it
    fit.white.value = std::sqrt(x[kWhite]);
    fit.white.limit = limit_of(likelihood, x, {true, instability, true}, kWhite, inflation);
  }
  fit.instability.value = std::sqrt(fits.all[kInstability]);
  fit.walk.value = std::sqrt(x[kWalk]);
  if (instability) {
    fit.instability = term_of(x[kInstability], std::sqrt(P(kInstability, kInstability)));
  } else {
    fit.instability.limit =
        limit_of(likelihood, fits.all, {true, true, true}, kInstability, inflation);
  }
  if (walk) {
    fit.walk = term_of(x[kWalk], std::sqrt(P(kWalk, kWalk)));
    fit.covariance(1, 1) = fit.walk.relative_sigma * fit.walk.relative_sigma;
    if (fit.white.shown) {
      fit.covariance(0, 1) = fit.covariance(1, 0) = P(kWhite, kWalk) / (4 * x[kWhite] * x[kWalk]);
    }
  } else {
    fit.walk.limit = limit_of(likelihood, x, {true, instability, true}, kWalk, inflation);
  }
  fit.walk_without_instability = std::sqrt(fits.no_instability[kWalk]);
  fit.power = {.white = x[kWhite],
               .instability = instability ? x[kInstability] : 0,
               .walk = walk ? x[kWalk] : 0};
  return fit;
}

}  // namespace

NoiseFit fit_noise(std::span<const PowerBand> all) {
  std::vector<PowerBand> bands(all.begin(), all.end());
  std::ranges::stable_sort(bands, {}, &PowerBand::frequency);
  double power = 0;
  for (const PowerBand& band : bands) power += band.count * band.power;
  if (total_count(bands) < kFewest || !(power > 0)) {
    throw InputError("fit_noise: found no noise, expected 8 coefficients above 0");
  }
  bands.resize(white_bands(bands));
  NoiseFit fit = fit_of(Likelihood(bands), bands);
  fit.white_up_to = bands.back().frequency;
  return fit;
}

}  // namespace chasles
