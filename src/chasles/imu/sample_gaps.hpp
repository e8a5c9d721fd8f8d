#pragma once

#include <optional>

#include <chasles/imu/sample_screen.hpp>
#include <chasles/imu/time_gaps.hpp>

namespace chasles {

/// TimeGaps of samples as they come from a sensor. Samples that an ImuBuffer drops do not count: a
/// sensor that is stuck or gives zeros leaves a gap as well.
class SampleGaps {
 public:
  static constexpr Time kLongest = TimeGaps::kLongest;
  using Gap = TimeGaps::Gap;

  explicit SampleGaps(const ImuRange& range, std::optional<Time> covered = std::nullopt)
      : screen_(range), gaps_(covered) {}

  /// The gap that this sample ends.
  std::optional<Gap> add(const ImuSample& sample);
  /// Time of the last sample that counts.
  std::optional<Time> last() const { return gaps_.last(); }

 private:
  SampleScreen screen_;
  TimeGaps gaps_;
};

}  // namespace chasles
