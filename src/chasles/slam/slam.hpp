#pragma once

#include <deque>
#include <optional>
#include <unordered_map>
#include <vector>

#include <chasles/filter/body_velocity_model.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/filter/stereo_measurement.hpp>
#include <chasles/slam/noise.hpp>
#include <chasles/slam/settings.hpp>

namespace chasles {

/// How far an estimate is to be believed.
enum class Health {
  kOk,
  kDegraded,  ///< running on the velocities alone, or on few or contradicting observations
  kLost,      ///< not finite: nothing after this can be believed
};
const char* name(Health health);

/// What the filter believes after a frame.
struct Estimate {
  Time time{};
  SE3 world_T_imu;
  Matrix6d pose_covariance = Matrix6d::Zero();  ///< reference chart: [theta; dp], world axes
  Eigen::VectorXd additive, additive_sigma;     ///< see Slam::additive_names
  double nis = 0;
  int nis_dof = 0;
  int observations = 0, used = 0, rejected = 0, added = 0, in_state = 0, landmarks = 0;
  Health health = Health::kOk;
};

/// The SLAM loop: feed it the events of a recording in the order of time.
class Slam {
 public:
  Slam(const Settings& settings, const StereoRig& rig, const Noise& noise);

  void process(const BodyVelocity& velocity);
  Estimate process(const FeatureFrame& frame);

  /// Names of Estimate::additive, with the unit behind the last underscore.
  std::vector<std::string> additive_names() const;

  const Ekf& filter() const { return filter_; }

 private:
  void predict_to(Time time, const BodyVelocity& held);
  void match(const FeatureFrame& frame);
  UpdateReport update(const FeatureFrame& frame);
  void retire_unseen();
  int begin(const FeatureFrame& frame);

  Settings settings_;
  StereoRig rig_;
  Noise noise_;
  BodyVelocityModel model_;
  StereoRows rows_;
  double gate_, loose_;
  Ekf filter_;
  std::optional<Time> time_;
  BodyVelocity velocity_;
  std::unordered_map<LandmarkId, int> last_seen_;  // frame number
  int frame_ = 0;
};

}  // namespace chasles
