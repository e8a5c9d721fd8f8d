#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include <chasles/estimate/estimate.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/imu/sample_screen.hpp>
#include <chasles/imu/time_gaps.hpp>

namespace chasles {

/// The motion between and after images, by the IMU alone.
struct PredictedState {
  Time time{};            ///< on the IMU's clock
  Time since_estimate{};  ///< time since the estimate that it begins with
  InertialState state;    ///< in the world of the estimates
  Eigen::Vector3d angular_rate_imu = Eigen::Vector3d::Zero();  ///< without bias [rad/s]
  /// Of the errors [theta; dp; v_world; accelerometer bias; gyroscope bias], standard error, world
  /// axes, as Estimate::covariance.
  Matrix15d covariance = Matrix15d::Zero();
};

/// Carries the last estimate of a visual-inertial estimator on through the samples: the prediction
/// that the filter itself makes, at any time and before the next image, for controllers. The
/// world's z axis points up. Where images come late or an estimated time offset moves, it begins
/// anew at the estimate's time.
///
/// With parameters of the IMU in the state the samples are corrected by their estimate. An Estimate
/// has no correlation of their errors with its biases, so the covariance is larger than it could
/// be.
///
/// The prediction ends, until the next estimate, where nobody should rely on it: at an estimate
/// that is lost, at a gap between samples that no estimator bridges (TimeGaps), and once the
/// estimate is older than kLongest. Memory and the time of a call are bounded thereby. One thread.
class StatePredictor {
 public:
  /// An estimate is carried on for so long.
  static constexpr Time kLongest = std::chrono::seconds(5);

  /// When the samples are integrated: as they come, so that at() costs the same at any time, or
  /// those that at() needs. The states are the same; but a saturated sample is bridged by later
  /// ones only where these are there.
  enum class Work { kAtOnce, kOnDemand };

  /// `noise` and `imu` as the estimator uses them.
  StatePredictor(const ImuNoise& noise, const ImuBuffer::Options& imu, Work work = Work::kAtOnce)
      : noise_(noise), work_(work), screen_(imu.range()), imu_(of_screened(imu)) {}

  StatePredictor with(Work work) const {
    StatePredictor other = *this;
    other.work_ = work;
    return other;
  }

  void add(const ImuSample& sample);
  /// Begins anew from this estimate. One that is lost or without velocity and biases ends the
  /// prediction.
  void correct(const Estimate& estimate);

  /// At a time since the last estimate; after the last sample it holds. None before an estimate,
  /// before the last one's time, more than TimeGaps::kLongest after the last sample, and after
  /// the prediction's end.
  std::optional<PredictedState> at(Time time);

 private:
  struct Step {
    Time time{};
    InertialState state;
    Matrix15d covariance;
  };
  Step moved(Step step, Time to);
  void find_intervals(Time from, Time to);
  void extend();
  static ImuBuffer::Options of_screened(ImuBuffer::Options imu) {
    imu.screened = true;
    return imu;
  }

  ImuNoise noise_;
  Work work_;
  SampleScreen screen_;
  ImuBuffer imu_;
  TimeGaps gaps_;
  std::optional<Time> after_gap_;  ///< of the first sample after the last gap
  std::vector<Step> steps_;  ///< the estimate, then one for each sample since; empty: no estimate
  std::optional<ImuCorrection> correction_;  ///< of the last estimate
  std::vector<ImuInterval> intervals_;
};

}  // namespace chasles
