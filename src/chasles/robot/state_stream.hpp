#pragma once

#include <atomic>
#include <optional>
#include <span>

#include <chasles/estimate/body_state.hpp>
#include <chasles/estimate/health.hpp>
#include <chasles/filter/past/past.hpp>
#include <chasles/robot/robot_slam.hpp>

namespace chasles {

/// What a robot's programs get. Called by the estimator's thread, and with Rate::kSamples by that
/// of the samples too.
class StateSink {
 public:
  virtual ~StateSink() = default;
  virtual void odometry(const BodyState& body, Time time) = 0;
  /// With Options::jumps, before the odometry of an estimate: its health, and how often the path
  /// has jumped so far, at loop closures and after losses.
  virtual void quality(Health /*health*/, std::size_t /*jumps*/) {}
  /// The frame of the estimates in that of the map in which the run found its place (REP 105).
  virtual void map_T_odom(const SE3& pose, Time time) = 0;
  virtual void points(std::span<const MapLandmark> landmarks, Time time) = 0;
};

/// Makes odometry and points of what RobotSlam estimates: none of an estimate that is lost.
class StateStream {
 public:
  enum class Rate { kImages, kSamples };
  struct Options {
    SE3 base_T_imu = {};        ///< where the IMU is on the robot
    Rate rate = Rate::kImages;  ///< of the odometry
    double points_period = 1;   ///< [s]; 0: no points
    bool jumps = false;         ///< the sink wants them
  };

  /// The sink must outlive this.
  StateStream(const Options& options, StateSink& sink) : options_(options), sink_(sink) {}

  /// Before the first call of the others.
  void set_slam(const RobotSlam& slam);

  /// RobotSlam::Callbacks::on_estimates. Of several estimates at once, which a start may give, the
  /// last counts.
  void take(std::span<const Estimate> estimates, VisualInertialSlam& slam);
  /// After RobotSlam has a sample: its time, and the time since the one before [s].
  void take_sample(Time time, double period);

  bool any() const { return any_; }  ///< whether there was an estimate

 private:
  bool points_are_due(Time time) const;
  void send(const std::optional<PredictedState>& state) const;

  Options options_;
  StateSink& sink_;
  const RobotSlam* slam_ = nullptr;
  double rate_density_ = 0;  // noise density of the gyroscope [rad/s/sqrt(Hz)]
  std::atomic<double> sample_period_ = 0.005;
  std::atomic<bool> any_ = false;
  std::optional<Time> last_points_;
};

}  // namespace chasles
