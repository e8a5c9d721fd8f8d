#pragma once

#include <optional>

#include <chasles/imu/sample_screen.hpp>

namespace chasles {

/// Finds the gaps between an IMU's samples that are too long to be bridged. Samples that an
/// ImuBuffer drops do not count: a sensor that is stuck or gives zeros leaves a gap as well.
class SampleGaps {
 public:
  /// After a longer gap the motion is unknown.
  static constexpr Time kLongest = std::chrono::milliseconds(500);
  struct Gap {
    Time last{}, next{};  ///< the samples before and after it
  };

  /// `covered`: as if there were a sample at this time.
  explicit SampleGaps(const ImuRange& range, std::optional<Time> covered = std::nullopt)
      : screen_(range), last_(covered) {}

  /// The gap that this sample ends.
  std::optional<Gap> add(const ImuSample& sample);
  /// Time of the last sample that counts.
  std::optional<Time> last() const { return last_; }

 private:
  SampleScreen screen_;
  std::optional<Time> last_;
};

}  // namespace chasles
