#include <algorithm>
#include <cmath>
#include <utility>

#include <chasles/base/median.hpp>
#include <chasles/calibrate/noise/even_samples.hpp>

namespace chasles {
namespace {

constexpr std::size_t kMostBridged = 4;
constexpr std::size_t kStride = 32;
// How fast the expected times follow the stamps: clocks drift.
constexpr double kFollow = 0.1;

using Signals = std::array<double, kImuSignals>;

Signals signals_of(const ImuSample& s) {
  return {s.specific_force_imu.x(), s.specific_force_imu.y(), s.specific_force_imu.z(),
          s.angular_rate_imu.x(),   s.angular_rate_imu.y(),   s.angular_rate_imu.z()};
}

std::vector<ImuSample> screened(std::span<const ImuSample> samples, const ImuRange& range,
                                SampleScreen::Counts& counts) {
  SampleScreen screen(range);
  std::vector<ImuSample> released;
  released.reserve(samples.size());
  for (const ImuSample& sample : samples) {
    const auto now = screen.add(sample);
    released.insert(released.end(), now.begin(), now.end());
  }
  counts = screen.counts();
  return released;
}

// Of a sample, from those that are `kStride` apart: rounded stamps and bursts average out.
double median_interval(const std::vector<ImuSample>& samples) {
  const std::size_t stride = std::min(kStride, samples.size() - 1);
  std::vector<double> intervals;
  for (std::size_t i = stride; i < samples.size(); ++i) {
    intervals.push_back(to_seconds(samples[i].time - samples[i - stride].time) /
                        static_cast<double>(stride));
  }
  return median(std::move(intervals));
}

void append(EvenSpan& span, const Signals& signals) {
  for (std::size_t i = 0; i < kImuSignals; ++i) span.signals[i].push_back(signals[i]);
}

// Interpolates `missing` samples between the span's last one and `next`.
void bridge(EvenSpan& span, const Signals& next, std::size_t missing) {
  Signals last{};
  for (std::size_t i = 0; i < kImuSignals; ++i) last[i] = span.signals[i].back();
  for (std::size_t k = 1; k <= missing; ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(missing + 1);
    Signals between{};
    for (std::size_t i = 0; i < kImuSignals; ++i)
      between[i] = last[i] + share * (next[i] - last[i]);
    append(span, between);
  }
}

void finish(EvenSpan&& span, EvenSamples& result) {
  if (span.count() < 2) return;
  span.period = to_seconds(span.end - span.begin) / static_cast<double>(span.count() - 1);
  result.spans.push_back(std::move(span));
}

}  // namespace

EvenSamples even_samples(std::span<const ImuSample> samples, const ImuRange& range) {
  EvenSamples result;
  const std::vector<ImuSample> kept = screened(samples, range, result.screen);
  if (kept.size() < 2) return result;
  result.period = median_interval(kept);
  EvenSpan span;
  span.begin = span.end = kept.front().time;
  append(span, signals_of(kept.front()));
  double expected = 0;  // time of the last sample, counted from the span's begin [s]
  for (std::size_t i = 1; i < kept.size(); ++i) {
    const double time = to_seconds(kept[i].time - span.begin);
    const double steps = std::round((time - expected) / result.period);
    if (to_seconds(kept[i].time - kept[i - 1].time) < result.period / 2) ++result.early;
    const auto missing = static_cast<std::size_t>(std::max(steps, 1.0)) - 1;
    const Signals now = signals_of(kept[i]);
    if (missing > kMostBridged) {
      finish(std::exchange(span, {}), result);
      span.begin = kept[i].time;
      expected = 0;
    } else {
      bridge(span, now, missing);
      result.lost += missing;
      expected += result.period * static_cast<double>(missing + 1);
      expected += kFollow * (time - expected);
    }
    append(span, now);
    span.end = kept[i].time;
  }
  finish(std::move(span), result);
  return result;
}

EvenSpan part_of(const EvenSpan& span, std::size_t from, std::size_t to) {
  EvenSpan part{.begin = span.begin + from_seconds(span.period * static_cast<double>(from)),
                .end = span.begin + from_seconds(span.period * static_cast<double>(to - 1)),
                .period = span.period,
                .signals = {}};
  for (std::size_t i = 0; i < kImuSignals; ++i) {
    part.signals[i].assign(span.signals[i].begin() + static_cast<std::ptrdiff_t>(from),
                           span.signals[i].begin() + static_cast<std::ptrdiff_t>(to));
  }
  return part;
}

}  // namespace chasles
