#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <chasles/camera/pixel_outcome.hpp>
#include <chasles/estimate/estimate.hpp>
#include <chasles/estimate/timed_measurement.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/initialise/inertial_start.hpp>
#include <chasles/loop/loop_closer.hpp>
#include <chasles/slam/clone_window.hpp>
#include <chasles/slam/filter_health.hpp>
#include <chasles/slam/inertial_settings.hpp>
#include <chasles/slam/landmark_updater.hpp>
#include <chasles/slam/propagator.hpp>
#include <chasles/slam/slam_context.hpp>
#include <chasles/slam/study_hooks.hpp>
#include <chasles/slam/track_updater.hpp>
#include <chasles/slam/undelayed_initialiser.hpp>
#include <chasles/slam/usable_observations.hpp>
#include <chasles/slam/zero_velocity_updater.hpp>

namespace chasles {

/// Visual-inertial SLAM. Feed samples and frames in the order of time; the samples up to a frame
/// (its time plus the time offset, `covers`) come before the frame.
/// Every observation is used once. A landmark in the state is observed from the present pose. With
/// `init: multi-view`, the observations of other points wait, with clones of the poses, until they
/// determine the depth; together they then initialise the landmark. With `fixed-depth`, the first
/// observation initialises it at an assumed depth. A track that ends earlier makes a null-space
/// update of its clones.
///
/// This class calls the steps of a frame in their order; each step is a class of its own. The steps
/// share the SlamContext. A copy is an independent filter.
class InertialSlam {
 public:
  /// Throws UsageError for settings that cannot be used. `prior`: a map in which the run finds its
  /// place, with Recognise::kAppearance. `starts_in_map`: nav is the frame of this map, so that the
  /// start is a place in it.
  InertialSlam(const InertialSlamSettings& settings, std::vector<Camera> cameras,
               const ImuNoise& noise, const ImuBuffer::Options& imu, double pixel_sigma,
               const InertialStart& start, std::shared_ptr<const LandmarkMap> prior = nullptr,
               bool starts_in_map = false);

  void process(const ImuSample& sample) {
    if (propagator_.add(sample)) standstill_.add(sample);
  }
  /// Applied at its own time, before the next frame that is not earlier; with an estimated time
  /// offset, at the time of that frame.
  void process(TimedMeasurement measurement) { propagator_.add(std::move(measurement)); }
  Estimate process(const FeatureFrame& frame);

  /// Where landmarks have returned in the frame just processed: the filter in this frame as if they
  /// had not, and would not later. conclude() then gives its estimate for the frame.
  std::shared_ptr<InertialSlam> take_without() { return std::exchange(without_, nullptr); }
  Estimate conclude(const FeatureFrame& frame) { return conclude(frame, {}); }
  /// Closures of a filter that this one replaces.
  void note_undone(std::span<const Closure> closures) { loops_.note_undone(closures); }

  /// The IMU's time of a camera time, by the present estimate of the time offset.
  Time clock(Time of_cameras) const { return context_.clock(of_cameras); }
  /// Whether the samples reach the time of this frame, and the end of its readout. If a frame is
  /// processed earlier, the filter holds the last sample; the error of this is not in the
  /// covariance.
  bool covers(Time frame) const { return propagator_.covers(context_, frame); }

  const Ekf& filter() const { return context_.filter; }
  /// The samples and measurements that it was fed.
  const Propagator& propagator() const { return propagator_; }
  /// Which landmarks were recognised, and where.
  const LoopCloser& loops() const { return loops_; }
  /// The map in nav axes, and the poses of all frames given all measurements; no poses without
  /// exact_map. Without exact_map, where the world's attitude is estimated, its error is not in the
  /// covariances of the landmarks.
  Past::Estimates past_nav() const;
  /// What another run can recognise, with Recognise::kAppearance: in the frame of the prior map if
  /// the run has found its place in it, else in nav. Without sessions[].name. Of own landmarks only
  /// those that have left before `until`, if it is given (on the cameras' clock).
  LandmarkMap landmark_map(std::optional<Time> until = std::nullopt) const;
  /// The outcomes of the usable observations of the last frame, in the frame's order.
  std::span<const PixelOutcome> outcomes() const { return landmarks_.outcomes(); }

 private:
  /// What the search for loops has done in this frame.
  struct Closing {
    bool returned = false;           ///< landmarks have returned
    std::optional<SE3> before = {};  ///< the pose before a closure by appearance
  };

  void propagate(const FeatureFrame& frame);
  Closing close_loops(const FeatureFrame& frame);
  Estimate conclude(const FeatureFrame& frame, const Closing& closing);
  void augment_clone(const FeatureFrame& frame, const Estimate& e);
  void update(const FeatureFrame& frame, const Closing& closing, Estimate& e);
  void retire(const FeatureFrame& frame);
  void null_space_update(const FeatureFrame& frame, Estimate& e);
  void initialise_landmarks(Estimate& e);
  void name_outcomes(const FeatureFrame& frame, const Estimate& e);
  void report(const FeatureFrame& frame, Estimate& e);
  const std::vector<const PixelObservation*>& observations(const FeatureFrame& frame);

  SlamContext context_;
  StudyHooks studies_;
  Propagator propagator_;
  LoopCloser loops_;
  ZeroVelocityUpdater standstill_;
  CloneWindow clones_;
  LandmarkUpdater landmarks_;
  TrackUpdater tracks_;
  UndelayedInitialiser undelayed_;
  FilterHealth health_;
  UsableObservations usable_;
  Time since_{};                           ///< time since the frame before
  std::shared_ptr<InertialSlam> without_;  ///< a copy without the landmarks that returned
};

}  // namespace chasles
