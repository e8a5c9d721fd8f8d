#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include <chasles/eval/association.hpp>
#include <chasles/eval/lag.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr double kShortestStep = 0.1, kLeastOverlap = 4;  // [s]
constexpr double kMostSteps = 6000;
constexpr double kLeastCorrelation = 0.5, kMargin = 0.2;
constexpr std::size_t kMostPeaks = 6;

// A speed at equal steps; a weight of 0 where it is not known.
struct Course {
  std::vector<double> value, weight;
};

Course course_of(const Trajectory& poses, SpeedKind kind, double step, bool centred, Time gap) {
  const double span = to_seconds(poses.back().time - poses.front().time);
  const auto n = static_cast<std::size_t>(span / step);
  std::vector<Eigen::Vector3d> rates(n, Eigen::Vector3d::Zero());
  Course course{.value = std::vector<double>(n), .weight = std::vector<double>(n)};
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double known = 0;
  std::optional<SE3> before = poses.front().pose;
  for (std::size_t i = 0; i < n; ++i) {
    const Time time = poses.front().time + from_seconds(static_cast<double>(i + 1) * step);
    const std::optional<SE3> now = pose_at(poses, time, gap);
    if (before && now) {
      course.weight[i] = 1;
      rates[i] = kind == SpeedKind::kTurning ? so3::log(before->R.transpose() * now->R)
                                             : Eigen::Vector3d(now->p - before->p);
      mean += rates[i];
      ++known;
    }
    before = now;
  }
  if (!centred || known == 0) mean.setZero();
  for (std::size_t i = 0; i < n; ++i) {
    if (course.weight[i] > 0) course.value[i] = (rates[i] - mean / std::max(known, 1.0)).norm();
  }
  return course;
}

// Correlation of a[i + lag] with b[i], where enough of both overlaps; else -1.
double correlation(const Course& a, const Course& b, std::ptrdiff_t lag, double least) {
  const auto from = std::max<std::ptrdiff_t>(0, -lag);
  const auto to = std::min(static_cast<std::ptrdiff_t>(b.value.size()),
                           static_cast<std::ptrdiff_t>(a.value.size()) - lag);
  double n = 0, sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for (std::ptrdiff_t i = from; i < to; ++i) {
    const auto ia = static_cast<std::size_t>(i + lag), ib = static_cast<std::size_t>(i);
    const double w = a.weight[ia] * b.weight[ib], x = a.value[ia], y = b.value[ib];
    n += w;
    sa += w * x;
    sb += w * y;
    saa += w * x * x;
    sbb += w * y * y;
    sab += w * x * y;
  }
  if (n < least) return -1;
  const double va = saa - sa * sa / n, vb = sbb - sb * sb / n;
  return va > 0 && vb > 0 ? (sab - sa * sb / n) / std::sqrt(va * vb) : -1;
}

std::vector<Lag> peaks_of(const std::vector<Lag>& all) {
  std::vector<Lag> peaks;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool rises = i == 0 || all[i].correlation >= all[i - 1].correlation;
    const bool falls = i + 1 == all.size() || all[i].correlation > all[i + 1].correlation;
    if (rises && falls && all[i].correlation >= kLeastCorrelation) peaks.push_back(all[i]);
  }
  std::ranges::stable_sort(peaks, std::greater{}, &Lag::correlation);
  if (peaks.size() > kMostPeaks) peaks.resize(kMostPeaks);
  std::erase_if(peaks, [best = peaks.empty() ? 0 : peaks.front().correlation](const Lag& peak) {
    return peak.correlation < best - kMargin;
  });
  const bool overlap = std::ranges::any_of(
      all, [](const Lag& lag) { return std::abs(lag.offset) <= lag.step && lag.correlation > -1; });
  if (overlap) peaks.push_back({.step = all.front().step});
  return peaks;
}

}  // namespace

std::vector<Lag> find_lags(const Trajectory& reference, const Trajectory& truth, SpeedKind kind,
                           bool biased, Time gap) {
  if (reference.size() < 2 || truth.size() < 2) return {};
  const double span_a = to_seconds(reference.back().time - reference.front().time);
  const double span_b = to_seconds(truth.back().time - truth.front().time);
  const double spacing = to_seconds(std::max(median_spacing(reference), median_spacing(truth)));
  const double step = std::max({kShortestStep, spacing, std::max(span_a, span_b) / kMostSteps});
  const double least = std::max(kLeastOverlap, std::min(span_a, span_b) / 2) / step - 2;
  const Time reach = std::max(gap, from_seconds(1.5 * step));
  const Course a = course_of(reference, kind, step, biased, reach);
  const Course b = course_of(truth, kind, step, biased, reach);
  const double between = to_seconds(reference.front().time - truth.front().time);
  const auto nb = static_cast<std::ptrdiff_t>(b.value.size());
  const auto na = static_cast<std::ptrdiff_t>(a.value.size());
  std::vector<Lag> all;
  for (std::ptrdiff_t lag = -nb + 1; lag < na; ++lag) {
    all.push_back({.offset = between + static_cast<double>(lag) * step,
                   .correlation = correlation(a, b, lag, least),
                   .step = step});
  }
  return peaks_of(all);
}

}  // namespace chasles
