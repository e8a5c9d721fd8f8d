#pragma once

#include <optional>
#include <span>
#include <vector>

#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// Leaves out what is no measurement, and counts it:
/// - a sample that is not finite, or not later than the one before;
/// - a sample of six zeros, which drivers write without a measurement;
/// - a spike: one sample leaves the signal, by far more than samples differ otherwise, and the next
///   returns to it. A blow that lasts for two samples is a measurement;
/// - a frozen sensor: a noisy signal repeats its six numbers for longer than 0.1 s. A simulated
///   sensor without noise may repeat them. The repeats wait until it is decided, so that none of a
///   frozen sensor is released;
/// - interpolated samples, with which somebody has filled a gap: for longer than 0.1 s, all six
///   numbers of a noisy sensor lie on straight lines. Both ends may be measurements, and so may the
///   first samples after an end. The others wait until it is decided, too.
/// Samples at the limit of the sensor's range are no spikes and not frozen: ImuBuffer bridges them.
class SampleScreen {
 public:
  struct Counts {
    int not_finite = 0, not_later = 0, zero = 0, spikes = 0, frozen = 0, interpolated = 0;
  };

  explicit SampleScreen(const ImuRange& range) : range_(range) {}

  /// The samples that are released, in order. One that may be a spike waits for the next. The span
  /// is valid until the next call.
  std::span<const ImuSample> add(const ImuSample& sample);

  const Counts& counts() const { return counts_; }

 private:
  /// How much one sensor's signal changes between two samples.
  struct Change {
    Eigen::Vector3d last = Eigen::Vector3d::Zero();
    double mean = 0;   ///< of the recent magnitudes
    double noisy = 0;  ///< share of the recent changes that differ from the one before
    int count = 0;
    void note(const Eigen::Vector3d& change);
    /// Noise changes anew with every sample, a motion that is sampled fast enough does not.
    bool is_noise() const;
    /// Over the limit of what is usual: a spike is above 1. Zero until enough changes are known.
    double unusual(double magnitude, double least) const;
  };

  enum class Repeat { kNone, kMayFreeze, kFrozen };
  Repeat compare(const ImuSample& sample);
  void follow_line(const ImuSample& sample);
  void leave_line();
  void check_for_spike(const ImuSample& sample);
  double unusual_change(const ImuSample& from, const ImuSample& to) const;
  bool at_limit(const ImuSample& sample) const;
  void release(const ImuSample& sample);

  ImuRange range_;
  Counts counts_;
  std::optional<Time> newest_;        ///< of the finite samples
  std::optional<ImuSample> last_;     ///< that was released
  std::optional<ImuSample> suspect_;  ///< that waits
  Change force_, rate_;
  std::optional<ImuSample> repeated_;  ///< the first sample with the present numbers
  int repeats_ = 0;
  int different_ = 0;            ///< consecutive samples that differ, before the repeats
  std::vector<ImuSample> held_;  ///< repeats that wait
  struct Line {
    std::vector<ImuSample> last = {};  ///< two samples, or fewer
    ImuSample first = {};              ///< of the present line
    int samples = 0;                   ///< that follow from two before them
    std::vector<ImuSample> held = {};  ///< those that wait
    bool interpolated = false;
  };
  Line line_;
  std::vector<ImuSample> released_;
};

}  // namespace chasles
