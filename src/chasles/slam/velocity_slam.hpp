#pragma once

#include <optional>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include <chasles/filter/body_velocity_model.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/filter/stereo_measurement.hpp>
#include <chasles/slam/health.hpp>
#include <chasles/slam/velocity_noise.hpp>
#include <chasles/slam/velocity_settings.hpp>

namespace chasles {

/// What the stages of a filter took for a frame [s]; no result depends on it.
struct FilterSeconds {
  double propagation = 0;  ///< of the state, since the frame before
  double update = 0;       ///< association, gate and update
  double landmarks = 0;    ///< that begin, change their form or retire
};

/// What the filter believes after a frame.
struct Estimate {
  Time time{};
  SE3 world_T_imu;
  Matrix6d pose_covariance =
      Matrix6d::Zero();  ///< [theta; dp], world axes [rad, m] (docs/charts.md)
  Eigen::VectorXd additive,
      additive_sigma;    ///< the motion's own states: VelocitySlam::additive_names
  double nis = 0;        ///< of the frame's observations and velocity, together
  int nis_dof = 0;       ///< its degrees of freedom; 0: nothing was updated
  int observations = 0;  ///< offered by the frame
  int used = 0;          ///< that updated the state
  int rejected = 0;      ///< of landmarks in the state, refused by the gate
  int added = 0;         ///< landmarks that the frame began
  int in_state = 0;      ///< landmarks of the state after the frame
  int landmarks = 0;     ///< landmarks of the whole map
  Health health = Health::kOk;
  FilterSeconds seconds = {};
};

/// The SLAM loop: feed it velocities and frames in the order of time. The world is the IMU frame at
/// the first event.
///
/// Recovered and counted: an observation that is not finite, or that names a landmark a second time
/// in its frame, is left out; a landmark that comes back after it was retired begins anew. Time
/// that runs backwards and velocities that are not finite throw InputError.
class VelocitySlam {
 public:
  /// Throws UsageError for settings that cannot be used.
  VelocitySlam(const VelocitySlamSettings& settings, const StereoRig& rig,
               const VelocitySlamNoise& noise);

  void process(const BodyVelocity& velocity);
  Estimate process(const FeatureFrame& frame);

  /// The pose, velocities and biases, and the whole map with its covariance.
  const Ekf& filter() const { return filter_; }

  /// Names of the numbers in Estimate::additive.
  std::vector<std::string> additive_names() const;

 private:
  using Observations = std::vector<const StereoObservation*>;
  struct Matched {
    std::vector<Measurement> known;  ///< of landmarks in the state
    Observations fresh;              ///< of landmarks that are not
  };

  void use_sample();
  void advance_to(Time time, const BodyVelocity& held);
  Observations usable(const FeatureFrame& frame) const;
  Matched match(const Observations& observations);
  int drop_outliers(std::vector<Measurement>& measurements) const;
  void choose(std::vector<Measurement>& measurements);
  int begin(const Observations& fresh);
  void retire_unseen();
  void see(const FeatureFrame& frame, Estimate& estimate);
  Health judge(const Estimate& estimate);

  VelocitySlamSettings settings_;
  StereoRig rig_;
  VelocitySlamNoise noise_;
  BodyVelocityModel model_;
  StereoRows rows_;
  double gate_, loose_gate_;
  Ekf filter_;
  std::optional<Time> now_;
  std::optional<BodyVelocity> velocity_;  ///< the latest
  std::optional<Measurement> sample_;     ///< it, where it is still to be applied
  int frame_ = 0;
  struct Last {
    int seen = 0, used = 0;  ///< numbers of frames
  };
  std::unordered_map<LandmarkId, Last> last_;  ///< of the landmarks of the state
  RecentUse recent_;
  double propagation_seconds_ = 0;  ///< since the last frame
};

}  // namespace chasles
