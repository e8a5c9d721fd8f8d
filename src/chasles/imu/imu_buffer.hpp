#pragma once

#include <optional>
#include <vector>

#include <chasles/imu/sample_screen.hpp>
#include <chasles/imu/strapdown.hpp>
#include <chasles/imu/vibration_noise.hpp>

namespace chasles {

/// Stores the samples of an IMU and returns the intervals between any two times. Faults are handled
/// and counted. What is no measurement is dropped (SampleScreen). Between samples of instants a gap
/// is bridged by the straight line through its neighbours (over the whole gap their mean); for
/// means the later sample holds.
///
/// In a gap, and where a sample is held for longer than `max_interval`, the noise variance is
/// multiplied by T / max_interval, T being the time without a sample. The noise density grows by
/// sigma sqrt(T), as sigma is the error of the bridge: the spread of the sensor's signal over the
/// last second, or less in a short gap.
///
/// A saturated sample only bounds the signal. Saturated samples are counted and bridged by the
/// straight line between their unsaturated neighbours: a signal that stays near the range is near
/// the line, and one that rings, or a sensor that fails, returns to it. Until a later neighbour
/// arrives, the earlier one is held; without any neighbour the sample itself is used. The noise
/// density grows by sigma sqrt(T), an error of sigma for the time T between the neighbours. Sigma
/// is half of the range plus the distance of the saturated samples from the line. The other
/// sensor's samples of the same time are used unchanged.
///
/// With `vibration_noise`, the noise density of an interval grows by what VibrationNoise finds in
/// the samples until the end of the interval.
class ImuBuffer {
 public:
  struct Options {
    ImuConvention convention = ImuConvention::kInstant;
    double max_interval = 0.05;        ///< a longer interval between two samples is a gap [s]
    double accelerometer_range = 1e9;  ///< |component| at or above: saturated [m/s^2]
    double gyroscope_range = 1e9;      ///< [rad/s]
    double vibration_noise = 0;        ///< factor on the variances that VibrationNoise adds
    bool screened = false;             ///< the samples have passed a SampleScreen

    ImuRange range() const {
      return {.accelerometer = accelerometer_range, .gyroscope = gyroscope_range};
    }
  };
  /// Samples, except `extrapolated`, which counts calls of between(). Of screened samples those of
  /// the screen are zero.
  struct Counts {
    int used = 0, not_finite = 0, not_later = 0, zero = 0, spikes = 0, frozen = 0, interpolated = 0,
        gaps = 0, saturated = 0, extrapolated = 0;
    /// Sets the counts of the screen.
    void note(const SampleScreen::Counts& left_out);
  };

  explicit ImuBuffer(const Options& options) : options_(options) {}

  /// Whether the sample is a measurement; one that may be a spike counts as such until the next.
  /// Screened samples come in order of time, and all are measurements.
  bool add(const ImuSample& sample);

  /// The intervals of [from, to], in order, split at the samples. Their tau sum to to - from
  /// exactly. Samples of instants: the signal is piecewise linear, and the value of an interval is
  /// the mean of its two ends. Means: sample k holds over (t_{k-1}, t_k]. Before the first sample
  /// and after the last the nearest one is held (counted once per call). Empty without samples, or
  /// if to <= from.
  std::vector<ImuInterval> between(Time from, Time to);
  /// The same into an existing list.
  void between(Time from, Time to, std::vector<ImuInterval>& result);

  /// The signal at an instant, as in between(): on the line between two samples of instants, or the
  /// mean that holds there. Before the first sample and after the last: the
  /// nearest one. None without samples.
  std::optional<ImuSample> at(Time time) const;

  /// Time of the last sample; none without samples.
  std::optional<Time> latest() const;

  /// Removes samples that no interval from `time` on needs; keeps the latest in any case.
  void drop_before(Time time);

  Counts counts() const;

 private:
  using Position = std::vector<ImuSample>::const_iterator;
  /// Accelerometer or gyroscope.
  struct Sensor {
    Eigen::Vector3d ImuSample::*value;
    bool ImuSample::*clipped;
    double range;
    bool of_instant;  ///< or the mean since the sample before
    bool saturated(const ImuSample& sample) const;
  };
  /// Mean and variance of a sensor's signal over the last second, per axis.
  struct Spread {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero(), variance = Eigen::Vector3d::Zero();
    void note(const Eigen::Vector3d& value, double weight);
    /// Sigma of the straight line through a gap of T seconds.
    double of_bridge(double T) const;
  };
  /// Estimated signal of a saturated sensor.
  struct Guess {
    Eigen::Vector3d mean;
    double extra_density = 0;
  };
  /// The signal in the middle of [start, end], between two samples.
  ImuSample value_between(const ImuSample& before, const ImuSample& after, Time start,
                          Time end) const;
  /// [start, end], with no sample inside; `after` is the first sample later than `start`.
  ImuInterval interval(Time start, Time end, const Position& after) const;
  /// Whether the sensor's value for an interval depends on a saturated sample.
  bool depends_on_saturated(const Sensor& sensor, const Position& after) const;
  /// The bridge between the unsaturated neighbours; `mean`: the interval's mean of the samples as
  /// measured.
  Guess bridge(const Sensor& sensor, Time start, Time end, const Position& after,
               const Eigen::Vector3d& mean) const;

  void keep(const ImuSample& sample);
  void note_vibration(const ImuSample& sample);
  /// The added noise of an interval that ends at `after` or before.
  AddedNoise added_at(const Position& after) const;

  Options options_;
  SampleScreen screen_{options_.range()};
  Sensor accelerometer_{&ImuSample::specific_force_imu, &ImuSample::force_clipped,
                        options_.accelerometer_range, is_force_of_instant(options_.convention)};
  Sensor gyroscope_{&ImuSample::angular_rate_imu, &ImuSample::rate_clipped,
                    options_.gyroscope_range, is_rate_of_instant(options_.convention)};
  Counts counts_;
  Spread force_, rate_;
  VibrationNoise vibration_;
  std::vector<ImuSample> samples_;
  std::vector<AddedNoise> added_;  ///< at the samples; empty without vibration_noise
};

}  // namespace chasles
