#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/noise/noise_calibration.hpp>
#include <chasles/calibrate/noise/standstill_parts.hpp>
#include <chasles/calibration/imu_range.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/recording/apply_calibration.hpp>

namespace chasles {
namespace {

constexpr double kLeastStandstill = 5;    // [s]
constexpr double kHighestFrequency = 10;  // of the fit [Hz]
constexpr double kLowestRate = 8;         // [Hz]
constexpr double kMostUneven = 0.02;      // share of the intervals
constexpr double kConfidence = 0.95;
constexpr double kCoarse = 0.5;  // a sigma of so many steps of the resolution

const char* unit_of(std::size_t signal) { return signal < 3 ? "m/s^2" : "rad/s"; }

std::string name_of_signal(std::size_t signal) {
  return fmt::format("the {}'s {} axis", signal < 3 ? "accelerometer" : "gyroscope",
                     "xyz"[signal % 3]);
}

std::vector<ImuSample> chosen_samples(const Recording& recording,
                                      const NoiseCalibrationSettings& settings) {
  if (recording.imu.empty()) {
    throw InputError(fmt::format(
        "{}: found no IMU samples, expected a recording with an IMU or a table of its samples",
        recording.name));
  }
  const Time first = first_event(recording);
  std::vector<ImuSample> samples = recording.imu;
  std::erase_if(samples, [&](const ImuSample& s) {
    const double time = to_seconds(s.time - first);
    return (settings.start && time < *settings.start) || (settings.stop && time > *settings.stop);
  });
  if (samples.size() > 1) return samples;
  throw UsageError(fmt::format(
      "--start {} s, --stop {} s: found {} of the {} IMU samples of {} in this time, expected "
      "more; they end {:.3f} s after its first event",
      settings.start.value_or(0),
      settings.stop ? fmt::format("{}", *settings.stop) : std::string("end"), samples.size(),
      recording.imu.size(), recording.name, to_seconds(recording.imu.back().time - first)));
}

void check_even(const EvenSamples& even, const NoiseCalibration& result) {
  const auto share = [&](std::size_t count) {
    return static_cast<double>(count) / static_cast<double>(result.samples);
  };
  if (share(even.early) > kMostUneven || share(even.lost) > kMostUneven) {
    throw InputError(fmt::format(
        "{}: the IMU's stamps are not even: {:.1f} % follow the one before after less than half of "
        "the median interval of {:.2f} ms, and {:.1f} % of the samples are missing; expected at "
        "most {:.0f} % of either: record with the sensor's own clock, and without losses",
        result.recording, 100 * share(even.early), 1e3 * even.period, 100 * share(even.lost),
        100 * kMostUneven));
  }
  if (result.rate < kLowestRate) {
    throw InputError(fmt::format("{}: found {:.2f} IMU samples a second, expected at least {:.0f}",
                                 result.recording, result.rate, kLowestRate));
  }
}

double total_seconds(std::span<const EvenSpan> spans) {
  double sum = 0;
  for (const EvenSpan& span : spans) sum += span.seconds();
  return sum;
}

StandstillParts parts_of(const EvenSamples& even, bool all_standstill) {
  if (!all_standstill) return find_standstill_parts(even.spans);
  StandstillParts parts;
  for (const EvenSpan& span : even.spans) {
    parts.longest = std::max(parts.longest, span.seconds());
    if (span.seconds() >= kShortestStandstill) parts.standstill.push_back(span);
  }
  return parts;
}

void check_range(const Recording& recording, std::span<const EvenSpan> standstills,
                 const std::vector<ImuSample>& samples) {
  const ImuRange range = range_of(recording);
  std::vector<ImuSample> inside_them;
  for (const ImuSample& sample : samples) {
    const bool inside = std::ranges::any_of(standstills, [&](const EvenSpan& span) {
      return span.begin <= sample.time && sample.time <= span.end;
    });
    if (inside) inside_them.push_back(sample);
  }
  const std::size_t saturated = count_saturated(inside_them, range);
  if (saturated == 0) return;
  throw InputError(fmt::format(
      "{}: {} samples of a standstill are at the edge of the sensor's range ({:g} m/s^2, {:g} "
      "rad/s), which "
      "cuts their noise: choose a larger range",
      recording.name, saturated, range.accelerometer, range.gyroscope));
}

// Mean, scatter and resolution over all parts.
void describe(std::span<const EvenSpan> spans, std::size_t i, StandstillSignal& signal) {
  std::vector<double> all;
  double square = 0;
  for (const EvenSpan& span : spans) {
    const std::vector<double>& x = span.signals[i];
    const double mean = std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
    for (const double value : x) square += (value - mean) * (value - mean);
    all.insert(all.end(), x.begin(), x.end());
  }
  const auto n = static_cast<double>(all.size());
  signal.mean = std::accumulate(all.begin(), all.end(), 0.0) / n;
  signal.sample_sigma = std::sqrt(square / std::max(1.0, n - static_cast<double>(spans.size())));
  std::ranges::sort(all);
  signal.resolution = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < all.size(); ++k) {
    // Two spellings of one number differ by its rounding.
    const double step = all[k] - all[k - 1];
    if (step > 1e-12 * std::abs(all[k])) signal.resolution = std::min(signal.resolution, step);
  }
}

std::vector<AllanPoint> allan_of(std::span<const EvenSpan> spans, std::size_t i,
                                 const NoisePower& power) {
  std::size_t most = 0;
  std::vector<std::vector<double>> sums;
  for (const EvenSpan& span : spans) {
    sums.push_back(running_sums(span.signals[i]));
    most = std::max(most, span.count() / 2);
  }
  const double period = spans.front().period;
  std::vector<AllanPoint> points;
  for (const std::size_t m : allan_factors(most)) {
    AllanSum sum;
    AllanPoint point{.seconds = static_cast<double>(m) * period};
    for (std::size_t s = 0; s < spans.size(); ++s) {
      const AllanSum of_span = allan_sum(sums[s], m);
      sum.squares += of_span.squares;
      sum.differences += of_span.differences;
      point.dof += allan_degrees_of_freedom(power, m, period, spans[s].count());
    }
    const double variance = sum.squares / (2 * static_cast<double>(sum.differences));
    point.deviation = std::sqrt(variance);
    point.differences = sum.differences;
    const double tail = (1 - kConfidence) / 2;
    point.lowest = std::sqrt(variance * point.dof / chi2_quantile(1 - tail, point.dof));
    point.highest = std::sqrt(variance * point.dof / chi2_quantile(tail, point.dof));
    point.of_fit = std::sqrt(allan_variance(power, m, period));
    points.push_back(point);
  }
  return points;
}

[[noreturn]] void reject_constant(const std::string& name, std::size_t i, double value,
                                  const char* when) {
  throw InputError(fmt::format(
      "{}: {} shows {:g} {} in all samples{}, expected noise: the sensor is not read, its "
      "resolution is too coarse, or a filter removes the noise",
      name, name_of_signal(i), value, unit_of(i), when));
}

void check_alive(const EvenSamples& even, const std::string& name) {
  for (std::size_t i = 0; i < kImuSignals && !even.spans.empty(); ++i) {
    const double first = even.spans.front().signals[i].front();
    const bool constant = std::ranges::all_of(even.spans, [&](const EvenSpan& span) {
      return std::ranges::all_of(span.signals[i], [&](double value) { return value == first; });
    });
    if (constant) reject_constant(name, i, first, "");
  }
}

StandstillSignal standstill_signal(std::span<const EvenSpan> spans, std::size_t i,
                                   const std::string& name) {
  StandstillSignal signal;
  describe(spans, i, signal);
  if (!(signal.sample_sigma > 0)) reject_constant(name, i, signal.mean, " of a standstill");
  std::vector<PowerBand> bands;
  for (const EvenSpan& span : spans) {
    const auto of_span = cosine_powers(span.signals[i], span.period, kHighestFrequency);
    bands.insert(bands.end(), of_span.begin(), of_span.end());
  }
  signal.fit = fit_noise(bands);
  signal.allan = allan_of(spans, i, signal.fit.power);
  return signal;
}

void remark_on_standstill(NoiseCalibration& result) {
  for (std::size_t i = 0; i < kImuSignals; ++i) {
    const StandstillSignal& signal = (*result.standstill)[i];
    const double highest = std::min(kHighestFrequency, result.rate / 2);
    if (signal.sample_sigma < kCoarse * signal.resolution) {
      result.remarks.push_back(fmt::format(
          "{} has steps of {:.3g} {}, and its samples scatter by {:.3g}: steps hide its noise",
          name_of_signal(i), signal.resolution, unit_of(i), signal.sample_sigma));
    }
    if (signal.fit.white_up_to < 0.7 * highest) {
      result.remarks.push_back(
          fmt::format("the noise of {} is that of a standstill up to {:.1f} Hz: above, there is "
                      "vibration or a filter, which the fit leaves out",
                      name_of_signal(i), signal.fit.white_up_to));
    }
  }
}

void calibrate_standstill(const Recording& recording, const std::vector<ImuSample>& samples,
                          const StandstillParts& parts, NoiseCalibration& result) {
  check_range(recording, parts.standstill, samples);
  for (const EvenSpan& span : parts.standstill) {
    const double begin = to_seconds(span.begin - samples.front().time);
    result.standstills.push_back({.begin = begin, .end = begin + span.seconds()});
  }
  result.standstill.emplace();
  for (std::size_t i = 0; i < kImuSignals; ++i) {
    (*result.standstill)[i] = standstill_signal(parts.standstill, i, recording.name);
  }
  remark_on_standstill(result);
}

}  // namespace

double NoiseCalibration::standstill_seconds() const {
  double sum = 0;
  for (const StandstillTimes& times : standstills) sum += times.end - times.begin;
  return sum;
}

TakenNoise NoiseCalibration::density(std::size_t first) const {
  TakenNoise taken{.value = 0, .is_limit = !standstill};
  for (std::size_t i = first; i < first + 3; ++i) {
    double value = 0;
    if (standstill) {
      const NoiseTerm& term = (*standstill)[i].fit.white;
      value = term.shown ? term.value : term.limit;
      taken.is_limit = taken.is_limit || !term.shown;
    } else if (motion) {
      value = motion->signals[i].quietest;
    }
    taken.value += value * value / 3;
  }
  taken.value = std::sqrt(taken.value);
  return taken;
}

std::optional<TakenNoise> NoiseCalibration::walk(std::size_t first) const {
  if (!standstill) return std::nullopt;
  TakenNoise taken;
  for (std::size_t i = first; i < first + 3; ++i) {
    const NoiseFit& fit = (*standstill)[i].fit;
    const bool known = fit.walk.shown || fit.instability.shown;
    const double value = known ? fit.walk_without_instability : fit.walk.limit;
    taken.is_limit = taken.is_limit || !known;
    taken.value += value * value / 3;
  }
  taken.value = std::sqrt(taken.value);
  return taken;
}

NoiseCalibration calibrate_noise(const Recording& recording,
                                 const NoiseCalibrationSettings& settings) {
  const std::vector<ImuSample> samples = chosen_samples(recording, settings);
  const EvenSamples even = even_samples(samples, range_of(recording));
  NoiseCalibration result{.recording = recording.name,
                          .seconds = to_seconds(samples.back().time - samples.front().time),
                          .rate = even.period > 0 ? 1 / even.period : 0,
                          .samples = samples.size(),
                          .interpolated = even.lost,
                          .left_out = static_cast<std::size_t>(
                              even.screen.not_finite + even.screen.not_later + even.screen.zero +
                              even.screen.spikes + even.screen.frozen + even.screen.interpolated),
                          .gaps = even.spans.size() > 1 ? even.spans.size() - 1 : 0,
                          .standstills = {},
                          .standstill = {},
                          .motion = {},
                          .stated = recording.imu_noise,
                          .remarks = {}};
  check_even(even, result);
  check_alive(even, recording.name);
  const StandstillParts parts = parts_of(even, settings.all_standstill);
  const double seconds = total_seconds(parts.standstill);
  if (seconds >= kLeastStandstill) calibrate_standstill(recording, samples, parts, result);
  result.motion = motion_noise(parts.motion);
  if (result.standstill || result.motion) return result;
  throw InputError(fmt::format(
      "{}: found {:.1f} s of samples, {:.1f} s of standstills of {:.0f} s or longer (the longest "
      "is {:.1f} s), expected at least {:.0f} s of them, or as much in motion at 64 Hz or "
      "more: put the sensor down and record for an hour",
      recording.name, result.seconds, seconds, kShortestStandstill, parts.longest,
      kLeastStandstill));
}

}  // namespace chasles
