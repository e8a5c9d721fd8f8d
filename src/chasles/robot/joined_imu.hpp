#pragma once

#include <optional>
#include <vector>

#include <chasles/imu/join_imu.hpp>
#include <chasles/pipeline/stamp_leaps.hpp>

namespace chasles {

/// An IMU whose accelerometer and gyroscope have a topic each: their samples are joined as those of
/// a recording (ImuJoiner). A single wrong stamp of a topic is left out (StampLeaps). Where the
/// clock of a topic jumps back, both begin anew, and the joined samples jump as well: until the
/// other topic jumps, what it brings is of the time before, and is left out. A topic that goes on
/// for two seconds of its stamps has not jumped.
class JoinedImu {
 public:
  JoinedImu(const ImuRange& range, const Eigen::Matrix3d& gyro_R_accel)
      : joiner_(range, gyro_R_accel) {}

  /// The samples that this one completes.
  std::vector<ImuSample> add_force(const AxesSample& force);
  std::vector<ImuSample> add_rate(const AxesSample& rate);
  /// What the last ones complete: nothing more comes.
  std::vector<ImuSample> finish();

  ImuJoiner::Counts counts() const { return joiner_.counts(); }
  /// Messages that were left out for their stamps.
  int wrong_stamps() const {
    return forces_.leaps.wrong() + rates_.leaps.wrong() + forces_.of_before + rates_.of_before;
  }

 private:
  struct Topic {
    StampLeaps<AxesSample> leaps = {};
    int jumps = 0;
    std::optional<Time> behind_since = {};  ///< the other topic has jumped
    int of_before = 0;                      ///< messages that were left out for it
  };
  static bool goes_on(Topic& topic, const Topic& other, Time time);
  void note_jump(Topic& topic, const Topic& other);

  ImuJoiner joiner_;
  Topic forces_, rates_;
};

}  // namespace chasles
