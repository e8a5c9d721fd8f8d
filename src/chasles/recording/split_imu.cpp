#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/base/median.hpp>
#include <chasles/calibration/imu_range.hpp>
#include <chasles/recording/sample_batches.hpp>
#include <chasles/recording/split_imu.hpp>
#include <chasles/recording/time_order.hpp>
#include <chasles/recording/time_spans.hpp>

namespace chasles {
namespace {

// Less is not worth a remark.
constexpr double kNoteworthyNoise = 1.02;
// A longer interval, in medians, is a gap.
constexpr double kGap = 3;
// A sensor of which more intervals are too long has no usual gaps: it is too slow.
constexpr double kMostLongIntervals = 0.1;

std::vector<Time> times_of(const std::vector<AxesSample>& samples) {
  std::vector<Time> times;
  for (const AxesSample& sample : samples) times.push_back(sample.time);
  return times;
}

// As the samples of a whole IMU.
void spread_stream(SensorStream& stream, const std::string& rows,
                   std::vector<std::string>& remarks) {
  std::vector<ImuSample> samples;
  for (const AxesSample& s : stream.samples) {
    samples.push_back({.time = s.time, .specific_force_imu = s.value});
  }
  spread_batches(samples, rows, remarks);
  for (std::size_t i = 0; i < samples.size(); ++i) stream.samples[i].time = samples[i].time;
}

void tidy_stream(const std::string& where, const char* what, SensorStream& stream,
                 std::vector<std::string>& remarks) {
  const std::string name = fmt::format("{}: {}", where, stream.name);
  if (stream.samples.empty()) {
    throw InputError(fmt::format("{}: holds no sample, expected those of the {}", name, what));
  }
  const std::string rows = fmt::format("samples of the {}", what);
  spread_stream(stream, rows, remarks);
  check_distinct(name, rows, times_of(stream.samples));
  bring_into_order(stream.samples, rows, remarks);
  leave_out_unknown(
      name, [](const AxesSample& s) { return s.value.allFinite(); }, rows, stream.samples, remarks);
}

// The mean time between two samples, without gaps [s]; infinite for one sample.
double period_of(const std::vector<AxesSample>& samples) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    intervals.push_back(to_seconds(samples[i].time - samples[i - 1].time));
  }
  if (intervals.empty()) return std::numeric_limits<double>::infinity();
  const double longest = kGap * median(intervals);
  double sum = 0;
  int count = 0;
  for (const double interval : intervals) {
    if (interval > longest) continue;
    sum += interval;
    ++count;
  }
  return sum / count;
}

// Of all intervals, those over which no sample is joined.
double share_of_long_intervals(const std::vector<AxesSample>& samples) {
  std::size_t count = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (samples[i].time - samples[i - 1].time > ImuJoiner::kLongestInterval) ++count;
  }
  return samples.size() < 2 ? 1
                            : static_cast<double>(count) / static_cast<double>(samples.size() - 1);
}

void check_fast_enough(const std::string& where, const char* what, const SensorStream& stream) {
  const double period = period_of(stream.samples),
               slowest = to_seconds(ImuJoiner::kLongestInterval),
               share = share_of_long_intervals(stream.samples);
  if (period <= slowest && share <= kMostLongIntervals) return;
  throw InputError(fmt::format(
      "{}: {}: the {} has {} samples, at {:.3g} Hz, and {:.0f} % of the intervals between them are "
      "longer than {:.2f} s: the {} is too slow, expected {:.0f} Hz or more, at most {:.0f} % of "
      "such "
      "intervals, and better 100 Hz: between two samples the motion is unknown, so set a higher "
      "rate "
      "in the driver or app",
      where, stream.name, what, stream.samples.size(), 1 / period, 100 * share, slowest, what,
      1 / slowest, 100 * kMostLongIntervals));
}

// What shown_range() sees in the accelerometer's own samples.
double shown_force_range(const std::vector<AxesSample>& forces) {
  std::vector<ImuSample> samples;
  for (const AxesSample& f : forces) {
    samples.push_back({.time = f.time, .specific_force_imu = f.value});
  }
  return shown_range(samples).accelerometer;
}

std::vector<ImuSample> joined_samples(ImuJoiner& joiner, const std::vector<AxesSample>& forces,
                                      const std::vector<AxesSample>& rates) {
  std::vector<ImuSample> all;
  const auto take = [&all](const std::vector<ImuSample>& some) {
    all.insert(all.end(), some.begin(), some.end());
  };
  std::size_t next = 0;
  for (const AxesSample& rate : rates) {
    while (next < forces.size() && forces[next].time < rate.time) {
      take(joiner.add_force(forces[next++]));
    }
    take(joiner.add_rate(rate));
  }
  while (next < forces.size() && joiner.waiting() > 0) take(joiner.add_force(forces[next++]));
  return all;
}

// The noise is white: what interpolation leaves of it over longer times has the accelerometer's own
// density, unless the gyroscope is slower.
std::string noise_text(double ratio, ImuNoise* noise) {
  const double factor = std::sqrt(interpolated_noise(ratio));
  if (factor < kNoteworthyNoise) {
    return "the noise densities are those of the calibration (docs/noise.md)";
  }
  if (noise != nullptr) noise->accelerometer_noise_density *= factor;
  return fmt::format(
      "the gyroscope is the slower one, so the accelerometer's noise density is {:.3g} times that "
      "of the calibration (docs/noise.md)",
      factor);
}

void remark_on_the_rest(const ImuJoiner::Counts& counts, std::size_t waiting,
                        std::vector<std::string>& remarks) {
  const std::size_t lost = counts.without_partner() + counts.dropped_rates + waiting;
  if (lost > 0) {
    remarks.push_back(fmt::format(
        "{} of {} samples of the gyroscope have no two samples of the accelerometer around them "
        "within {:.2f} s ({} before its first, {} after its last, {} in gaps): left out",
        lost, counts.rates, to_seconds(ImuJoiner::kLongestInterval), counts.before_forces, waiting,
        counts.in_gaps + counts.dropped_rates));
  }
  if (counts.not_measured == 0) return;
  remarks.push_back(fmt::format(
      "{} of {} samples of the accelerometer are no measurements (zeros, spikes, a sensor that "
      "repeats its numbers): left out",
      counts.not_measured, counts.forces));
}

}  // namespace

void join_streams(const std::string& where, SensorStream forces, SensorStream rates,
                  const Eigen::Matrix3d& gyro_R_accel, Recording& recording) {
  if (recording.imu_convention == ImuConvention::kIntervalMean) {
    throw InputError(fmt::format(
        "{}: imu_convention is interval-mean, but {} and {} have the accelerometer and the "
        "gyroscope apart, which are joined as values of instants: expected instant",
        where, forces.name, rates.name));
  }
  tidy_stream(where, "accelerometer", forces, recording.remarks);
  tidy_stream(where, "gyroscope", rates, recording.remarks);
  check_overlap(
      where, {.what = "accelerometer samples of " + forces.name, .times = times_of(forces.samples)},
      {.what = "gyroscope samples of " + rates.name, .times = times_of(rates.samples)});
  check_fast_enough(where, "accelerometer", forces);
  check_fast_enough(where, "gyroscope", rates);
  ImuRange range = recording.imu_range;
  if (!std::isfinite(range.accelerometer)) range.accelerometer = shown_force_range(forces.samples);
  ImuJoiner joiner(range, gyro_R_accel);
  recording.imu = joined_samples(joiner, forces.samples, rates.samples);
  recording.imu_range.accelerometer = turned_range(range.accelerometer, gyro_R_accel);
  if (recording.imu.empty()) {
    throw InputError(fmt::format(
        "{}: no sample of {} lies between two samples of {} within {:.2f} s of each other, "
        "expected both sensors at the same time",
        where, rates.name, forces.name, to_seconds(ImuJoiner::kLongestInterval)));
  }
  const double of_forces = period_of(forces.samples), of_rates = period_of(rates.samples);
  recording.remarks.push_back(fmt::format(
      "the accelerometer ({}, {:.4g} Hz) and the gyroscope ({}, {:.4g} Hz) are joined: {} samples "
      "at the gyroscope's times, with the accelerometer interpolated; {}",
      forces.name, 1 / of_forces, rates.name, 1 / of_rates, recording.imu.size(),
      noise_text(of_rates / of_forces, recording.imu_noise ? &*recording.imu_noise : nullptr)));
  remark_on_the_rest(joiner.counts(), joiner.waiting(), recording.remarks);
}

}  // namespace chasles
