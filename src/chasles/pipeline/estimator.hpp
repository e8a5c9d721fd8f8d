#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <chasles/pipeline/run_settings.hpp>
#include <chasles/pipeline/sensor_event.hpp>
#include <chasles/slam/inertial_session.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/window/window.hpp>
#include <chasles/velocity/velocity_noise.hpp>

namespace chasles {

/// Counts of an estimator. Those that do not apply are absent or 0.
struct EstimatorReport {
  ImuBuffer::Counts imu;
  int resets = 0;                 ///< of a lost filter
  int dropped_frames = 0;         ///< late, repeated, or without samples near
  PlaceCounts places = {};        ///< in the prior map
  std::vector<Closure> closures;  ///< of a filter that recognises landmarks by appearance
  std::vector<Time> recognised;   ///< of the same (InertialSlam::recognised)
  /// Likewise: the landmarks of its recognised tracks (InertialSession::known_as).
  std::map<LandmarkId, LandmarkId> known_as;
  std::optional<BatchReport> batch;
  std::optional<WindowReport> window;
};

/// Sensor data in, estimates out: the common interface of filter, batch and window, for
/// visual-inertial and stereo-velocity runs. make_estimator() makes one. Events come in order of
/// time; an event that the kind of run does not use is ignored. One thread.
class Estimator {
 public:
  virtual ~Estimator() = default;

  /// The estimates that this event completes. A frame's estimate may come with a later event, and
  /// none comes before the run has started. The visual-inertial filter recovers from any input
  /// (InertialSession). Others throw InputError for velocities that are not finite and time that
  /// runs backwards, Error(kDiverged) where a window finds no minimum. Where samples are missing
  /// for more than InertialSession::kLongestGap, a window ends and begins again; batch estimation
  /// estimates the parts separately.
  virtual std::vector<Estimate> process(const EstimatorEvent& event) = 0;
  /// The estimates of the frames that still wait; no more events come.
  virtual std::vector<Estimate> finish() { return {}; }
  /// For batch estimation, once, after finish(): smooth() returns the estimates of all keyframes,
  /// which replace all earlier ones. Throws as smooth() of smooth/batch/, but not BatchStopped:
  /// where `stop` returns true it ends within a second or so, with none, and map() stays the
  /// filter's.
  virtual bool smooths() const { return false; }
  virtual std::vector<Estimate> smooth(const StopRequest& /*stop*/ = {}) { return {}; }
  /// After finish(), for a whole recording: throws InputError where a window had no landmark.
  virtual void check() const {}

  /// Whether the run has started, and otherwise the conditions that are not met.
  virtual bool started() const { return true; }
  virtual std::string why_not_started() const { return {}; }
  /// True if further events change nothing, because the estimate is lost.
  virtual bool ended() const { return false; }

  /// All landmarks of the run, in the world of the estimates.
  virtual std::vector<MapLandmark> map() const = 0;
  /// The same with the poses of all frames given all measurements, which a filter has.
  virtual Past::Estimates past() const { return {.landmarks = map(), .poses = {}}; }
  /// The landmarks of the map as they were initialised, in that order: of a stereo-velocity filter.
  virtual std::span<const MapLandmark> initial_landmarks() const { return {}; }
  /// Those that the next frame may still change; absent: all.
  virtual std::optional<std::vector<LandmarkId>> in_state() const = 0;
  /// Names of the components of v_world, if any, and Estimate::additive.
  virtual std::vector<std::string> state_names() const = 0;
  virtual EstimatorReport report() const = 0;
  /// The problems of batch estimation with an IMU, at their minimum, after smooth(): one for each
  /// part (InertialBatchResult::terms).
  virtual std::vector<std::shared_ptr<const BatchTerms>> batch_terms() const { return {}; }

  /// The latest estimate of the gyroscope bias [rad/s], for the front end; zero before a start.
  virtual Eigen::Vector3d gyroscope_bias() const { return Eigen::Vector3d::Zero(); }
  /// What another run can recognise; none of an estimator that does not recognise landmarks by
  /// their appearance, and before a start. Without the names of its sessions.
  virtual std::optional<LandmarkMap> landmark_map() const { return std::nullopt; }
  /// The filter whose map has a joint covariance (Ekf::visit_map_covariance); null: none.
  virtual const Ekf* filter() const { return nullptr; }
  /// Sets a callback for every frame that a visual-inertial filter takes, with the outcomes of its
  /// observations, before its estimate is returned.
  virtual void set_observer(InertialSession::OutcomeObserver /*observer*/) {}
};

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
