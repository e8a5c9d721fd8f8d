#pragma once

#include <chrono>
#include <optional>

#include <chasles/base/time.hpp>

namespace chasles {

/// Finds the gaps between an IMU's measurements that are too long to be bridged. The samples have
/// passed a SampleScreen: a sensor that is stuck or gives zeros leaves a gap as well.
class TimeGaps {
 public:
  /// After a longer gap the motion is unknown.
  static constexpr Time kLongest = std::chrono::milliseconds(500);
  struct Gap {
    Time last{}, next{};  ///< the samples before and after it
  };

  /// `covered`: as if there were a sample at this time.
  explicit TimeGaps(std::optional<Time> covered = std::nullopt) : last_(covered) {}

  /// The gap that a measurement at this time ends. A time that is not later changes nothing.
  std::optional<Gap> add(Time time);
  /// Time of the last one.
  std::optional<Time> last() const { return last_; }

 private:
  std::optional<Time> last_;
};

}  // namespace chasles
