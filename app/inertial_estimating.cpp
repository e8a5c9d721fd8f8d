#include "inertial_estimating.hpp"

#include <utility>

#include <chasles/lab/batch_trial.hpp>

#include "run_landmarks.hpp"

namespace chasles::app {
namespace {

void append(const std::vector<WindowMotion>& motions, std::vector<InertialEstimate>& estimates) {
  for (const WindowMotion& motion : motions) estimates.push_back(estimate_of(motion));
}

std::vector<InertialEstimate> estimates_of(const std::vector<WindowMotion>& motions) {
  std::vector<InertialEstimate> estimates;
  append(motions, estimates);
  return estimates;
}

}  // namespace

InertialBatchInput smoothing_input(const Recording& recording, const InertialRunSettings& settings,
                                   const InertialDrive& drive, const InertialEstimate& first) {
  const InertialStart start{.time = first.time,
                            .nav_T_imu = first.motion.nav_T_imu,
                            .v_nav = first.motion.v_nav,
                            .accelerometer_bias = first.motion.biases.head<3>(),
                            .gyroscope_bias = first.motion.biases.tail<3>(),
                            .covariance = first.motion.covariance};
  InertialBatchInput input = batch_input(recording, settings.filter, start);
  input.imu = imu_options(recording);
  input.pixel_sigma = drive.pixel_sigma;
  input.samples.clear();
  input.frames.clear();
  return input;
}

InertialEstimating::InertialEstimating(const Recording& recording,
                                       const InertialRunSettings& settings,
                                       const InertialDriveOptions& options,
                                       const InertialDrive& drive)
    : recording_(recording),
      settings_(settings),
      drive_(drive),
      keyframes_(options.estimator.window),
      session_(session_for(recording, settings, drive, options.from_truth)) {
  if (!options.estimator.filter()) check_smoothing(settings.filter);
}

std::vector<InertialEstimate> InertialEstimating::process(const ImuSample& sample) {
  if (window_) return estimates_of(window_->process(sample));
  session_.process(sample);
  if (keyframes_ > 0) samples_.push_back(sample);
  return {};
}

std::vector<InertialEstimate> InertialEstimating::process(const FeatureFrame& frame) {
  if (window_) return estimates_of(window_->process(frame));
  if (keyframes_ > 0) frames_.push_back(frame);
  std::vector<InertialEstimate> estimates = session_.process(frame);
  return keyframes_ > 0 && !estimates.empty() ? begin(estimates.front()) : estimates;
}

std::vector<InertialEstimate> InertialEstimating::finish() {
  std::vector<InertialEstimate> estimates;
  if (!window_) {
    estimates = session_.finish();
    if (keyframes_ == 0 || estimates.empty()) return estimates;
    estimates = begin(estimates.front());
  }
  append(window_->finish(), estimates);
  return estimates;
}

// The events of until now in the order in which they came.
std::vector<InertialEstimate> InertialEstimating::begin(const InertialEstimate& first) {
  window_.emplace(smoothing_input(recording_, settings_, drive_, first), settings_.filter.chart,
                  settings_.batch, keyframes_);
  std::vector<InertialEstimate> estimates;
  auto sample = samples_.begin();
  for (const FeatureFrame& frame : std::exchange(frames_, {})) {
    append(window_->process(frame), estimates);
    for (; sample != samples_.end() && window_->waiting(); ++sample) {
      append(window_->process(*sample), estimates);
    }
  }
  for (; sample != samples_.end(); ++sample) append(window_->process(*sample), estimates);
  samples_.clear();
  return estimates;
}

Eigen::Vector3d InertialEstimating::gyroscope_bias() const {
  return window_ ? window_->gyroscope_bias() : session_.gyroscope_bias();
}

std::vector<MapLandmark> InertialEstimating::map() const {
  return window_ ? window_->map() : session_.map_nav();
}

std::vector<LandmarkId> InertialEstimating::in_state() const {
  return window_ ? window_->in_window() : session_.in_state();
}

void InertialEstimating::report(InertialDrive& drive) const {
  if (window_ && !drive.interrupted) window_->check();
  drive.run.landmarks = run_landmarks(map());
  drive.resets = session_.resets();
  drive.imu = session_.imu_counts();
  drive.dropped_frames = session_.dropped_frames();
  if (!window_) return;
  drive.window = window_->report();
  drive.imu = window_->report().imu;
  drive.dropped_frames = window_->report().dropped_frames;
}

}  // namespace chasles::app
