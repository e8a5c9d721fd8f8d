#pragma once

#include <optional>
#include <vector>

#include <chasles/imu/strapdown.hpp>

namespace chasles {

/// Takes the samples of an IMU as they come and gives the intervals between any two times, whatever
/// the device did. Recovered and counted: a sample that is not finite, repeats or precedes the
/// latest time is dropped; a gap is bridged by the straight line between its neighbours (kInstant:
/// over the whole gap their mean) or by the later sample (kIntervalMean).
///
/// What was not measured is not known as well: in a gap, and where a sample is held for longer than
/// `max_interval`, the noise variance grows with the time without a sample, by the factor
/// (that time) / max_interval.
///
/// A sensor at the edge of its range says no more than that its signal is there or beyond. Its
/// saturated samples are counted and bridged by the straight line between the neighbours that are
/// not (a signal that rises to the range and stays near is near the line; one that rings, or fails,
/// comes back to it); as long as no later neighbour has come, the earlier one is held, and without
/// any the sample is used. The noise density grows by sigma sqrt(T), T being the time between the
/// neighbours and sigma half of the range and how far from the line the sensor was seen: an
/// error of sigma all that time. The other sensor's samples of the same time are used as they are.
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
  /// The same into a list that there is.
  void between(Time from, Time to, std::vector<ImuInterval>& result);

  /// The signal at an instant, as between() has it: on the line between two samples (kInstant), or
  /// the sample that holds there (kIntervalMean); before the first and after the last the nearest.
  /// None without any sample.
  std::optional<ImuSample> at(Time time) const;

  /// Time of the last sample; none without any.
  std::optional<Time> latest() const;

  /// Forgets samples that no interval from `time` on needs; the latest is always kept.
  void forget_before(Time time);

  const Counts& counts() const { return counts_; }

 private:
  using Position = std::vector<ImuSample>::const_iterator;
  /// One of the two.
  struct Sensor {
    Eigen::Vector3d ImuSample::*value;
    double range;
    bool saturated(const ImuSample& sample) const;
  };
  /// What a sensor would have shown.
  struct Guess {
    Eigen::Vector3d mean;
    double extra_density = 0;
  };
  /// [start, end], with no sample inside; `after` is the first sample later than `start`.
  ImuInterval interval(Time start, Time end, const Position& after) const;
  /// Whether what the sensor says of an interval rests on a saturated sample.
  bool rests_on_saturated(const Sensor& sensor, const Position& after) const;
  /// By its neighbours that are not saturated; `mean`: by the samples as they are.
  Guess bridge(const Sensor& sensor, Time start, Time end, const Position& after,
               const Eigen::Vector3d& mean) const;

  Options options_;
  Sensor accelerometer_{&ImuSample::specific_force_imu, options_.accelerometer_range};
  Sensor gyroscope_{&ImuSample::angular_rate_imu, options_.gyroscope_range};
  Counts counts_;
  std::vector<ImuSample> samples_;
};

}  // namespace chasles
