#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <chasles/pipeline/run_settings.hpp>
#include <chasles/pipeline/sensor_event.hpp>
#include <chasles/slam/inertial_session.hpp>
#include <chasles/slam/velocity_noise.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/window/window.hpp>

namespace chasles {

/// What an estimator counted. What does not apply to it is absent or 0.
struct EstimatorReport {
  ImuBuffer::Counts imu;
  int resets = 0;          ///< of a lost filter
  int dropped_frames = 0;  ///< late, repeated, or without samples near
  std::optional<BatchReport> batch;
  std::optional<WindowReport> window;
};

/// Sensors in, estimates out: the interface of filter, batch and window, with an IMU or with body
/// velocities. make_estimator() makes one. Events come in the order of time; an event that the kind
/// of run does not use is ignored. One thread.
class Estimator {
 public:
  virtual ~Estimator() = default;

  /// The estimates that this event brings. A frame's estimate may come with a later event, and none
  /// comes before the run has started.
  virtual std::vector<Estimate> process(const EstimatorEvent& event) = 0;
  /// The estimates of frames that still wait: no more events come.
  virtual std::vector<Estimate> finish() { return {}; }
  /// Batch estimation: after finish(), smooth() has the estimates of all keyframes, which replace
  /// those so far. It throws as smooth() of smooth/batch/ does.
  virtual bool smooths() const { return false; }
  virtual std::vector<Estimate> smooth() { return {}; }
  /// After finish(), of a whole recording: throws InputError where a window had no landmark.
  virtual void check() const {}

  /// Whether the run has started, and what it still needs otherwise.
  virtual bool started() const { return true; }
  virtual std::string why_not_started() const { return {}; }
  /// No further event changes anything: the estimate is lost for good.
  virtual bool ended() const { return false; }

  /// All landmarks of the run, in the world of the estimates.
  virtual std::vector<MapLandmark> map() const = 0;
  /// Those that the next frame may still change; absent: all.
  virtual std::optional<std::vector<LandmarkId>> in_state() const = 0;
  /// What v_world, if any, and Estimate::additive are, a name a number.
  virtual std::vector<std::string> state_names() const = 0;
  virtual EstimatorReport report() const = 0;

  /// The latest estimate of the gyroscope's bias [rad/s], for the front end; zero before a start.
  virtual Eigen::Vector3d gyroscope_bias() const { return Eigen::Vector3d::Zero(); }
  /// The filter whose map has a joint covariance (Ekf::visit_map_covariance); null: none is kept.
  virtual const Ekf* filter() const { return nullptr; }
  /// `observer` is called with every frame that a visual-inertial filter takes, and the outcomes of
  /// its observations, before its estimate comes.
  virtual void set_observer(InertialSession::OutcomeObserver /*observer*/) {}
};

/// What a visual-inertial estimator needs; the settings' pixel_sigma, where given, comes before the
/// sensors'. `start`: where to begin; none: the run finds its start. Throws UsageError for settings
/// that do not go together.
std::unique_ptr<Estimator> make_estimator(const InertialRunSettings& settings,
                                          InertialSensors sensors,
                                          std::optional<InertialStart> start = std::nullopt);

/// What a stereo-velocity estimator needs to know of its sensors.
struct VelocitySensors {
  StereoRig rig;
  VelocitySlamNoise noise;  ///< choose_noise()
};
std::unique_ptr<Estimator> make_estimator(const VelocityRunSettings& settings,
                                          const VelocitySensors& sensors);

}  // namespace chasles
