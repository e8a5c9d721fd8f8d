#pragma once

#include <optional>
#include <vector>

#include <chasles/imu/join_imu.hpp>
#include <chasles/pipeline/stamp_leaps.hpp>

namespace chasles::app {

/// An IMU whose accelerometer and gyroscope have a topic each: their samples are joined as those of
/// a recording (ImuJoiner). A single wrong stamp of a topic is left out, and a jump of its clock
/// begins that topic anew (StampLeaps); the joined samples then jump as well.
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
  int wrong_stamps() const { return leaps_of_forces_.wrong() + leaps_of_rates_.wrong(); }

 private:
  ImuJoiner joiner_;
  StampLeaps<AxesSample> leaps_of_forces_, leaps_of_rates_;
};

}  // namespace chasles::app
