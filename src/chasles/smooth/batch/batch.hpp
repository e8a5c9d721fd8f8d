#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <chasles/estimate/estimate.hpp>
#include <chasles/filter/calibration.hpp>
#include <chasles/filter/inertial_model.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/initialise/inertial_start.hpp>
#include <chasles/smooth/batch/batch_settings.hpp>

namespace chasles {

/// A motion at a time of the IMU's clock, in nav.
struct TimedMotion {
  Time time{};
  InertialState state;
};

/// The input of batch estimation from a recording.
struct InertialBatchInput {
  std::vector<Camera> cameras;  ///< where the search begins, if the calibration is estimated
  ImuNoise noise;
  ImuBuffer::Options imu;
  double pixel_sigma = 1;  ///< [px]
  double match_sigma = 0;  ///< TrackNoise::match [px]
  Time time_offset{};      ///< added to a frame's time to get the IMU's time; where it begins
  /// What is estimated of the calibration, before any measurement; none: all of it is known. A
  /// singular covariance gets the floor of the start's.
  std::optional<Calibration> calibration = {};
  /// Rows of its errors that are considered: they keep this prior, and their uncertainty counts
  /// (considered_rows of slam/inertial_calibration.hpp).
  std::vector<int> considered = {};
  std::vector<ImuSample> samples;
  std::vector<FeatureFrame> frames;
  /// The prior: its state, with `start_covariance`. The covariance may be singular: exact
  /// components get a sigma of 1e-6 m, rad, m/s, m/s^2, or 1e-8 rad/s.
  InertialStart start;
  Matrix15d start_covariance = Matrix15d::Zero();
  /// Initial states of the search, in order of time, for example the filter's estimates. A keyframe
  /// without one is predicted from the previous keyframe by the samples. Empty: all of them are
  /// predicted.
  std::vector<TimedMotion> initial = {};
};

/// The results of batch estimation besides the estimates.
struct BatchReport {
  int keyframes = 0, links = 0;
  int observations = 0;   ///< used ones
  int unusable = 0;       ///< not finite, of an unknown camera, or twice in a frame
  int gated = 0;          ///< rejected by the gate; not among `observations`
  double loss_width = 0;  ///< from the settings, or chosen by auto
  int outliers =
      0;  ///< used observations beyond 2.5 standard deviations or behind the camera, at the end
  int dropped_frames = 0;  ///< not later than the previous one, or without samples nearby
  int landmarks = 0;
  int landmarks_left_out =
      0;                    ///< observed once, without parallax, or left with one view by the gate
  int landmarks_split = 0;  ///< additional landmarks from splits (BatchSettings::max_rejections)
  ImuBuffer::Counts imu;
  BatchSolver solver = BatchSolver::kAuto;  ///< of the linear system
  int iterations = 0;                       ///< all steps, also those that were not accepted
  int successful = 0;                       ///< steps that lowered the cost
  double initial_cost = 0, final_cost = 0;  ///< half of the weighted squares
  /// Twice the final cost over its degrees of freedom. It is near 1 (a little less with a robust
  /// loss) where the stated noise is right and the search found the right minimum.
  double cost_per_dof = 0;
  std::vector<double> costs;  ///< after every step, also those that were not accepted
  bool converged = false;     ///< by its tolerance, or because almost no decrease is left
  /// The fraction of the cost by which a full Gauss-Newton step from the end of the search would
  /// lower it, if the problem were linear. Almost 0 at a minimum.
  double decrease_left = 0;
  /// The search ended by its tolerance, but not at a minimum: steps failed until they were too
  /// short to change the cost.
  bool stalled = false;
  double covariance_factor =
      1;            ///< of all covariances (ResidualWalk); of several parts the largest
  std::string end;  ///< why it ended, in Ceres's words
  int parts = 1;    ///< that were estimated separately, and those of them that failed
  int parts_failed = 0;
  std::string failure;  ///< of the first that failed
  /// Directions of the state at the start that neither pixels nor samples determine to 1 m/s, 0.1
  /// rad, 1 m/s^2 or 0.1 rad/s, in words. Their estimates come from the start's covariance.
  std::vector<std::string> unobservable;
  double seconds_solve = 0,
         seconds_covariance = 0;  ///< processor time [s]; differs from run to run
};

/// Above this BatchReport::cost_per_dof the stated noise is wrong, or the minimum is.
inline constexpr double kMostCostPerDof = 2;

/// Whether the search converged, at a minimum that fits the data.
bool fits_the_data(const BatchReport& report);
/// Sets the health of all estimates: kOk if the report fits_the_data(), else kDegraded.
void set_health(std::span<Estimate> estimates, const BatchReport& report);

/// Polled during batch estimation: true ends it.
using StopRequest = std::function<bool()>;
/// Thrown by smooth() where a StopRequest ends it.
struct BatchStopped : std::exception {
  const char* what() const noexcept override { return "batch estimation was stopped"; }
};

struct BatchTerms;  // batch_terms.hpp

struct InertialBatchResult {
  std::vector<Estimate> estimates;     ///< of all keyframes; the first is the start
  std::vector<MapLandmark> landmarks;  ///< in nav
  BatchReport report;
  /// The problem at its minimum; of several parts those that were estimated.
  std::vector<std::shared_ptr<const BatchTerms>> terms = {};
};

/// The most probable motion and landmarks for all samples and frames. Minimises, over the states of
/// all keyframes and all landmarks,
///
///   |start|^2 + sum |samples between two keyframes|^2 + sum loss(|pixel|^2),
///
/// each whitened by its covariance (docs/batch.md), by the Levenberg-Marquardt method in the
/// coordinates of the error chart. The minimum is the same in all charts. One thread; the same
/// bytes on every run. An estimated calibration is one more state, with its prior as a term.
///
/// The covariance of every keyframe is that of the problem linearised at the minimum, times
/// BatchReport::covariance_factor. Considered errors c, of covariance C, add S C S^T, S the
/// derivative of the minimum by c.
///
/// Recovered and counted: see BatchReport. Throws InputError for insufficient data: fewer than two
/// frames, no landmark that is observed twice, no samples, a gap between samples longer than half a
/// second, or noise that is zero. Throws InputError as well where the problem is ill-posed: a
/// direction at the start is unobservable (BatchReport::unobservable), and a position has a sigma
/// above 1 m and a tenth of the distance travelled. The message names the direction.
/// Error(kDiverged) where no finite cost was found. UsageError for an unknown chart and for
/// settings that cannot be used. BatchStopped as `stop` says.
InertialBatchResult smooth(const InertialBatchInput& input, const std::string& chart,
                           const BatchSettings& settings, const StopRequest& stop = {});

}  // namespace chasles
