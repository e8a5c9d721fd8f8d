#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include <chasles/estimate/estimate.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/imu/sample_gaps.hpp>

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
/// The prediction ends, until the next estimate, where nobody should rely on it: at an estimate
/// that is lost, at a gap between samples that no estimator bridges (SampleGaps), and once the
/// estimate is older than kLongest. Memory and the time of a call are bounded thereby. One thread.
class StatePredictor {
 public:
  /// An estimate is carried on for so long.
  static constexpr Time kLongest = std::chrono::seconds(5);

  /// `noise` and `imu` as the estimator uses them.
  StatePredictor(const ImuNoise& noise, const ImuBuffer::Options& imu)
      : noise_(noise), imu_(imu), gaps_(imu.range()) {}

  void add(const ImuSample& sample);
  /// Begins anew from this estimate. One that is lost or without velocity and biases ends the
  /// prediction.
  void correct(const Estimate& estimate);

  /// At a time since the last estimate; after the last sample it holds. None before an estimate,
  /// before the last one's time, more than SampleGaps::kLongest after the last sample, and after
  /// the prediction's end.
  std::optional<PredictedState> at(Time time);

 private:
  struct Step {
    Time time{};
    InertialState state;
    Matrix15d covariance;
  };
  Step moved(Step step, Time to);
  void extend();

  ImuNoise noise_;
  ImuBuffer imu_;
  SampleGaps gaps_;
  std::optional<Time> after_gap_;  ///< of the first sample after the last gap
  std::vector<Step> steps_;  ///< the estimate, then one for each sample since; empty: no estimate
  std::vector<ImuInterval> intervals_;
};

}  // namespace chasles
