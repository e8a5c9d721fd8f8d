#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <chasles/imu/imu_sample.hpp>
#include <chasles/imu/sample_screen.hpp>

namespace chasles {

/// The six signals of an IMU: specific force x, y, z [m/s^2], then angular rate x, y, z [rad/s].
inline constexpr std::size_t kImuSignals = 6;

/// Samples of an IMU at even times, without a gap.
struct EvenSpan {
  Time begin{}, end{};                                   ///< times of the first and the last sample
  double period = 0;                                     ///< (end - begin) / (count - 1) [s]
  std::array<std::vector<double>, kImuSignals> signals;  ///< of equal length, above 1

  std::size_t count() const { return signals[0].size(); }
  double seconds() const { return period * static_cast<double>(count()); }
};

/// The samples as spans without a gap, and what was found on the way.
struct EvenSamples {
  double period = 0;  ///< the median interval of a sample, over 32 of them [s]
  std::vector<EvenSpan> spans;
  std::size_t lost = 0;         ///< single samples that are missing, and were interpolated
  std::size_t early = 0;        ///< stamps that are nearer to the one before than half a period
  SampleScreen::Counts screen;  ///< samples that are no measurement, and were left out
};

/// Up to four missing samples in a row are interpolated; where more are missing a new span begins.
/// A span of fewer than two samples is left out. Samples are counted, not taken at their stamps:
/// stamps may jitter by less than half a period. What is no measurement (SampleScreen) is left out
/// first.
EvenSamples even_samples(std::span<const ImuSample> samples, const ImuRange& range);

/// The part of a span from one index up to before another one. Needs from + 1 < to <= count().
EvenSpan part_of(const EvenSpan& span, std::size_t from, std::size_t to);

}  // namespace chasles
