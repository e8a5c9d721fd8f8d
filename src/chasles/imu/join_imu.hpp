#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include <chasles/imu/sample_screen.hpp>

namespace chasles {

/// One sample of an accelerometer [m/s^2] or of a gyroscope [rad/s] that is read by itself.
struct AxesSample {
  Time time{};
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
};

/// Joins the samples of an accelerometer with those of a gyroscope to IMU samples at the
/// gyroscope's times. The specific force is interpolated linearly between the accelerometer samples
/// before and after. A gyroscope sample waits for the latter; none is extrapolated. The result does
/// not depend on the order in which the two streams arrive, only on the order within each.
///
/// Accelerometer samples that are no measurement are left out before (SampleScreen): a spike would
/// spread over all samples around it. Where an accelerometer sample is at the limit of the range,
/// the samples that it has a part in are marked (ImuSample::force_clipped).
///
/// docs/noise.md derives the noise of what results.
class ImuJoiner {
 public:
  /// Between two accelerometer samples that are further apart there is no sample: as in ImuBuffer,
  /// a longer interval is a gap.
  static constexpr Time kLongestInterval = std::chrono::milliseconds(50);
  /// Samples of one stream that wait for the other; one more, and the oldest is dropped.
  static constexpr std::size_t kMostWaiting = 100'000;

  struct Counts {
    std::size_t forces = 0, rates = 0;  ///< samples that came
    std::size_t joined = 0;
    // Gyroscope samples that gave none.
    std::size_t before_forces = 0;   ///< earlier than the first accelerometer sample
    std::size_t in_gaps = 0;         ///< between accelerometer samples that are too far apart
    std::size_t late_rates = 0;      ///< not later than the one before
    std::size_t unknown_rates = 0;   ///< not finite
    std::size_t dropped_rates = 0;   ///< no place to wait
    std::size_t dropped_forces = 0;  ///< accelerometer samples without a place to wait
    std::size_t not_measured = 0;    ///< accelerometer samples that SampleScreen left out
    std::size_t without_partner() const { return before_forces + in_gaps; }
  };

  /// The joined force is gyro_R_accel times that of the accelerometer, whose range is along its own
  /// axes.
  explicit ImuJoiner(const ImuRange& range = {},
                     const Eigen::Matrix3d& gyro_R_accel = Eigen::Matrix3d::Identity())
      : range_(range), gyro_R_accel_(gyro_R_accel), screen_(range) {}

  /// The samples that this one completes, in order of time.
  std::vector<ImuSample> add_force(const AxesSample& force);
  std::vector<ImuSample> add_rate(const AxesSample& rate);

  /// The clock of that stream has jumped: its samples that wait are discarded, and its next one is
  /// the first again.
  void restart_forces();
  void restart_rates();

  /// Gyroscope samples that wait for an accelerometer sample.
  std::size_t waiting() const { return rates_.size(); }
  Counts counts() const;

 private:
  struct Force {
    Time time{};
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    bool clipped = false;
  };
  std::vector<ImuSample> join();
  void join_one(const AxesSample& rate, std::vector<ImuSample>& joined);

  ImuRange range_;
  Eigen::Matrix3d gyro_R_accel_;
  SampleScreen screen_;
  std::deque<Force> forces_;
  std::deque<AxesSample> rates_;
  std::optional<Time> last_rate_;
  Counts counts_;
  std::size_t screened_before_ = 0;  ///< by the screens before a restart
};

/// The variance of white noise that is left of an accelerometer's, over times that are longer than
/// its period, when its samples are interpolated linearly at times that have nothing to do with its
/// own: 1 for a gyroscope that is as fast or faster, and above 1.3 from twice its period on.
/// `ratio`: the period of the gyroscope over that of the accelerometer, positive (docs/noise.md).
double interpolated_noise(double ratio);

/// A range that no force reaches after a turn by R, unless it was at `range` before; of sensors
/// whose samples at the limit are marked. Infinite stays infinite.
double turned_range(double range, const Eigen::Matrix3d& R);

}  // namespace chasles
