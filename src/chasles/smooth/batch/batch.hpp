#pragma once

#include <string>
#include <vector>

#include <chasles/filter/inertial_model.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/slam/estimate.hpp>
#include <chasles/slam/inertial_start.hpp>
#include <chasles/smooth/batch/batch_settings.hpp>

namespace chasles {

/// A motion at a time of the IMU's clock, in nav.
struct TimedMotion {
  Time time{};
  InertialState state;
};

/// What batch estimation takes from a recording.
struct InertialBatchInput {
  std::vector<Camera> cameras;
  ImuNoise noise;
  ImuBuffer::Options imu;
  double pixel_sigma = 1;  ///< [px]
  Time time_offset{};      ///< to be added to a frame's time to have the IMU's clock
  std::vector<ImuSample> samples;
  std::vector<FeatureFrame> frames;
  /// The prior: its state, with `start_covariance` (which may be singular: what is known exactly is
  /// taken to be known to 1e-6 m, rad, m/s, m/s^2, and 1e-8 rad/s).
  InertialStart start;
  Matrix15d start_covariance = Matrix15d::Zero();
  /// Where to begin the search, times rising, as the filter's estimates; a keyframe without one is
  /// predicted from the keyframe before by the samples. Empty: all of them are.
  std::vector<TimedMotion> initial = {};
};

/// What came out, besides the estimates.
struct BatchReport {
  int keyframes = 0, links = 0;
  int observations = 0;   ///< that were used
  int unusable = 0;       ///< not finite, of an unknown camera, or twice in a frame
  int gated = 0;          ///< left out by the gate; not among `observations`
  double loss_width = 0;  ///< that of the settings, or what auto came to
  int outliers = 0;  ///< of the used ones, beyond 2.5 deviations or behind the camera, at the end
  int dropped_frames = 0;  ///< not later than the one before, or without samples near
  int landmarks = 0;
  int landmarks_left_out = 0;  ///< seen once, without parallax, or left with one view by the gate
  int landmarks_split = 0;     ///< how many more BatchSettings::max_rejections made of them
  ImuBuffer::Counts imu;
  BatchSolver solver = BatchSolver::kAuto;  ///< of the linear system
  int iterations = 0;                       ///< steps that were tried
  int successful = 0;                       ///< that lowered the cost
  double initial_cost = 0, final_cost = 0;  ///< half of the weighted squares
  /// Twice the final cost over its degrees of freedom: near 1 (a little less with a robust loss)
  /// where the sensors are as stated and the minimum is the right one.
  double cost_per_dof = 0;
  std::vector<double> costs;  ///< after every step that was tried
  bool converged = false;     ///< by its tolerance, or because next to nothing is left to gain
  /// The part of the cost by which a whole step of Gauss and Newton from where the search ended
  /// would lower it, were the problem linear: next to 0 at a minimum.
  double decrease_left = 0;
  /// It ended by its tolerance, but not at a minimum: steps were refused until they were too short
  /// to change the cost.
  bool stalled = false;
  std::string end;  ///< why it ended, in Ceres's words
  /// What neither pixels nor samples tell to 1 m/s, 0.1 rad, 1 m/s^2 or 0.1 rad/s: directions of
  /// the state at the start, in words. What is said of them comes from the start's covariance.
  std::vector<std::string> unobservable;
  double seconds_solve = 0, seconds_covariance = 0;  ///< of the processor; differ from run to run
};

/// Above this BatchReport::cost_per_dof the sensors are not as stated, or the minimum is a wrong
/// one.
inline constexpr double kMostCostPerDof = 2;

/// Whether the search converged, at a minimum that fits the data.
bool fits_the_data(const BatchReport& report);

struct InertialBatchResult {
  std::vector<Estimate> estimates;     ///< of all keyframes, the first of them the start
  std::vector<MapLandmark> landmarks;  ///< in nav
  BatchReport report;
};

/// The most probable motion and landmarks, all samples and frames given: minimises, over the states
/// of all keyframes and all landmarks,
///
///   |start|^2 + sum |samples between two keyframes|^2 + sum loss(|pixel|^2),
///
/// each whitened by its covariance (docs/batch.md), by Levenberg's and Marquardt's method in the
/// error chart's coordinates; the minimum is the same in all charts. One thread; the same bytes on
/// every run.
///
/// The covariance of every keyframe is that of the linearised problem at the minimum.
///
/// Recovered and counted: see BatchReport. Throws InputError where there is nothing to estimate
/// from (fewer than two frames, no landmark that is seen twice, no samples, a gap between samples
/// longer than half a second, noise that is zero), and where the problem is ill-posed: something of
/// the start is not observable (BatchReport::unobservable) and leaves a position uncertain by more
/// than 1 m and a tenth of the way; the message names it. Error(kDiverged) where no finite cost was
/// found. UsageError for an unknown chart and for settings that cannot be used.
InertialBatchResult smooth(const InertialBatchInput& input, const std::string& chart,
                           const BatchSettings& settings);

}  // namespace chasles
