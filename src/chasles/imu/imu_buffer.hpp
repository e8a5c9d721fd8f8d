#pragma once

#include <deque>
#include <vector>

#include <chasles/imu/strapdown.hpp>

namespace chasles {

/// Takes the samples of an IMU as they come and gives the intervals between any two times, whatever
/// the device did. Recovered and counted: a sample that is not finite, repeats or precedes the
/// latest time is dropped; a gap is bridged by the straight line between its neighbours (kInstant:
/// over the whole gap their mean) or by the later sample (kIntervalMean); a sample at the edge of
/// the sensor's range is used but counted.
///
/// What was not measured is not known as well: in a gap, and where a sample is held for longer than
/// `max_interval`, the noise variance grows with the time without a sample, by the factor
/// (that time) / max_interval.
class ImuBuffer {
 public:
  struct Options {
    ImuConvention convention = ImuConvention::kInstant;
    double max_interval = 0.05;        ///< a longer one between two samples is a gap [s]
    double accelerometer_range = 1e9;  ///< |component| at or above: saturated [m/s^2]
    double gyroscope_range = 1e9;      ///< [rad/s]
  };
  /// Samples, except `extrapolated`, which counts calls of between().
  struct Counts {
    int used = 0, not_finite = 0, not_later = 0, gaps = 0, saturated = 0, extrapolated = 0;
  };

  explicit ImuBuffer(const Options& options) : options_(options) {}

  void add(const ImuSample& sample);

  /// The intervals that make up [from, to], in order, cut at the samples; tau sums to the
  /// difference exactly. kInstant: the signal is piecewise linear, an interval's value the mean of
  /// its two ends. kIntervalMean: sample k holds over (t_{k-1}, t_k]. Before the first sample and
  /// after the last the nearest one is held (counted once a call). Without any sample, or to <=
  /// from: empty.
  std::vector<ImuInterval> between(Time from, Time to);

  /// Forgets samples that no interval from `time` on needs; the latest is always kept.
  void forget_before(Time time);

  const Counts& counts() const { return counts_; }

 private:
  using Position = std::deque<ImuSample>::const_iterator;
  /// [start, end], with no sample inside; `after` is the first sample later than `start`.
  ImuInterval interval(Time start, Time end, const Position& after) const;

  Options options_;
  Counts counts_;
  std::deque<ImuSample> samples_;
};

}  // namespace chasles
