#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <chasles/pipeline/run_settings.hpp>
#include <chasles/pipeline/sensor_event.hpp>
#include <chasles/slam/inertial_session.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/window/window.hpp>
#include <chasles/velocity/velocity_noise.hpp>

namespace chasles {

/// Counts and figures of an estimator. Those that do not apply are absent, empty or 0.
struct EstimatorReport : SlamReport {
  std::optional<BatchReport> batch;
  /// The problems of batch estimation with an IMU, at their minimum: one for each part
  /// (InertialBatchResult::terms).
  std::vector<std::shared_ptr<const BatchTerms>> batch_terms;
  std::optional<WindowReport> window;
};

/// Where an estimator stands between two events.
struct EstimatorStatus {
  bool started = true;
  std::string why_not_started = {};  ///< the conditions that are not met
  bool ended = false;    ///< further events change nothing, because the estimate is lost
  bool smooths = false;  ///< complete() is batch estimation
  /// The latest estimate of the gyroscope bias [rad/s], for the front end; zero before a start.
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();
};

/// All landmarks and poses of a run, in the world of the estimates.
struct EstimatedMap {
  std::vector<MapLandmark> landmarks = {};
  std::vector<PastPose> poses = {};  ///< of all frames given all measurements, which a filter has
  /// The landmarks as they were initialised, in that order: of a stereo-velocity filter.
  std::vector<MapLandmark> initial = {};
  /// Those that the next frame may still change; absent: all.
  std::optional<std::vector<LandmarkId>> in_state = {};
};

/// Sensor data in, estimates out: the common interface of filter, batch and window, for
/// visual-inertial and stereo-velocity runs. make_estimator() makes one. Events come in order of
/// time; an event that the kind of run does not use is ignored. One thread.
class Estimator {
 public:
  virtual ~Estimator() = default;
  Estimator(const Estimator&) = delete;
  Estimator& operator=(const Estimator&) = delete;

  /// The estimates that this event completes. A frame's estimate may come with a later event, and
  /// none comes before the run has started. The visual-inertial filter recovers from any input
  /// (InertialSession). Others throw InputError for velocities that are not finite and time that
  /// runs backwards, Error(kDiverged) where a window finds no minimum. Where samples are missing
  /// for more than InertialSession::kLongestGap, a window ends and begins again; batch estimation
  /// estimates the parts separately.
  virtual std::vector<Estimate> process(const EstimatorEvent& event) = 0;
  /// The estimates of the frames that still wait; no more events come.
  virtual std::vector<Estimate> finish() { return {}; }
  /// Once, after finish(), for a whole recording. Batch estimation returns the estimates of all
  /// keyframes, which replace all earlier ones. It throws as smooth() of smooth/batch/, but not
  /// BatchStopped: where `stop` returns true it ends within a second or so, with none, and the map
  /// stays the filter's. Others return none. Throws InputError where a window had no landmark.
  virtual std::vector<Estimate> complete(const StopRequest& /*stop*/ = {}) { return {}; }

  virtual EstimatorStatus status() const = 0;
  virtual EstimatorReport report() const = 0;
  virtual EstimatedMap whole_map() const = 0;
  /// What another run can recognise; none of an estimator that does not recognise landmarks by
  /// their appearance, and before a start. Without the names of its sessions.
  virtual std::optional<LandmarkMap> landmark_map() const { return std::nullopt; }

  /// Names of the components of v_world, if any, and Estimate::additive.
  const std::vector<std::string>& state_names() const { return state_names_; }
  bool started() const { return status().started; }
  /// What the last event was to the estimator: the IMU samples that are measurements, of those that
  /// waited for it and itself (SampleScreen). For the front end; valid until the next event.
  std::span<const ImuSample> measured() const { return measured_; }
  std::string why_not_started() const { return status().why_not_started; }
  std::vector<MapLandmark> map() const { return whole_map().landmarks; }

  /// Sets a callback for every frame that a visual-inertial filter takes, with the outcomes of its
  /// observations, before its estimate is returned.
  void set_observer(InertialSession::OutcomeObserver observer) { observer_ = std::move(observer); }

 protected:
  explicit Estimator(std::vector<std::string> state_names) : state_names_(std::move(state_names)) {}
  void observe(const FeatureFrame& frame, std::span<const PixelOutcome> outcomes) const {
    if (observer_) observer_(frame, outcomes);
  }

  std::span<const ImuSample> measured_;

 private:
  std::vector<std::string> state_names_;
  InertialSession::OutcomeObserver observer_;
};

/// The filter of an estimator whose map has a joint covariance (PastView::visit_map_covariance):
/// that of stereo-velocity runs. Null: another estimator.
const Ekf* filter_with_joint_map(const Estimator& estimator);

/// Makes a visual-inertial estimator. A pixel_sigma in the settings overrides the sensors'.
/// `start`: the initial state; none: the run initialises itself. `prior`: a map in which a filter
/// finds its place, with recognise=appearance. Throws as validate(), and UsageError for a map with
/// another estimator or setting.
std::unique_ptr<Estimator> make_estimator(const InertialRunSettings& settings,
                                          InertialSensors sensors,
                                          std::optional<InertialStart> start = std::nullopt,
                                          std::shared_ptr<const LandmarkMap> prior = nullptr);

/// The sensors of a stereo-velocity run.
struct VelocitySensors {
  StereoRig rig;
  VelocitySlamNoise noise;  ///< from choose_noise()
};
std::unique_ptr<Estimator> make_estimator(const VelocityRunSettings& settings,
                                          const VelocitySensors& sensors);

}  // namespace chasles
