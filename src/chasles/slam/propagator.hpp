#pragma once

#include <vector>

#include <chasles/estimate/timed_measurement.hpp>
#include <chasles/filter/calibration.hpp>
#include <chasles/filter/inertial_model.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/slam/slam_context.hpp>

namespace chasles {

/// Propagates the filter by the samples of the IMU, on the clocks of cameras and IMU, and applies
/// measurements of other sensors on the way.
class Propagator {
 public:
  /// The noise of the IMU as stated; the settings scale it.
  Propagator(const InertialSlamSettings& settings, const ImuNoise& noise,
             const ImuBuffer::Options& imu);

  /// Whether the sample is a measurement.
  bool add(const ImuSample& sample) { return imu_.add(sample); }
  /// Applied at its own time, before the next frame that is not earlier; with an estimated time
  /// offset, at the time of that frame.
  void add(TimedMeasurement measurement) { timed_.push_back(std::move(measurement)); }

  /// Moves the state to the time of a frame. Throws InputError where time runs backwards, and
  /// without samples.
  void propagate(SlamContext& x, Time frame);
  /// The prediction of this frame, which first estimates use. Call it again where the frame of the
  /// world changes.
  void note_prediction(const State& x);

  /// Whether the samples reach the time of this frame, and the end of its readout.
  bool covers(const SlamContext& x, Time frame) const;
  /// The motion in nav at the time of the state.
  NavState motion(const SlamContext& x);
  /// The derivative of its errors by those of the core, after motion().
  const Eigen::MatrixXd& motion_derivative() const { return nav_.derivative; }

  ImuBuffer::Counts imu_counts() const { return imu_.counts(); }
  const TimedMeasurementCounts& timed_counts() const { return timed_counts_; }
  int timed_waiting() const { return static_cast<int>(timed_.size()); }

 private:
  void apply_timed(SlamContext& x, Time frame);
  /// The motion while the image of the present frame was read out.
  void note_readout(SlamContext& x);
  void advance_to(SlamContext& x, Time time);
  const Prediction& predict_to(const SlamContext& x, Time time);
  Vector9d rate_at(const InertialState& state, const State& x, Time of_imu) const;

  InertialModel model_;
  ImuBuffer imu_;
  std::vector<TimedMeasurement> timed_;  ///< that wait for a frame
  TimedMeasurementCounts timed_counts_;
  bool at_image_ = false;      ///< the state is at the time of an image, no longer at the start's
  PredictedMotion predicted_;  ///< for first estimates
  std::vector<ImuInterval> intervals_;
  Prediction prediction_;
  NavScratch nav_;
};

}  // namespace chasles
