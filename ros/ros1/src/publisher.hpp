#pragma once

#include <atomic>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <chasles/bags/ros_messages.hpp>
#include <chasles/pipeline/visual_inertial_slam.hpp>

#include "parameters.hpp"
#include "transport.hpp"

namespace chasles::ros1 {

/// Publishes the state of the body: by the frames of REP 105, map -> odom -> base_link, where odom
/// is the world of the estimates and map that of a saved map, or the same.
class Publisher {
 public:
  /// `rate_noise_density`: of the gyroscope [rad/s/sqrt(Hz)]. All must outlive this.
  Publisher(Transport& transport, const NodeParameters& parameters);
  void set_rate_noise(double density) { rate_noise_density_ = density; }

  /// The frame of the IMU's messages, and static transforms: by them base_link is found.
  void set_imu_frame(const std::string& frame);
  void add_transforms(const std::vector<RosTransform>& transforms);

  /// At the rate of the IMU: odometry and tf. In the order of time.
  void publish(const PredictedState& state);
  /// For each frame: frame_odometry, pose, pose_in_map; from time to time path and points. On the
  /// estimator's thread.
  void publish(std::span<const Estimate> estimates, VisualInertialSlam& slam);
  /// The run begins anew.
  void reset();

 private:
  SE3 base_T_imu();
  void publish_frame(const Estimate& estimate, VisualInertialSlam& slam, const SE3& base_T_imu,
                     double rate_variance);
  void publish_place(const Estimate& estimate, const SE3& base_T_imu);
  void publish_path(Time now);
  void publish_points(Time now, const VisualInertialSlam& slam);

  Transport& transport_;
  const NodeParameters& parameters_;
  double rate_noise_density_ = 0;

  std::mutex mutex_;  // of the next seven
  std::string imu_frame_;
  std::vector<RosTransform> transforms_;
  std::optional<SE3> base_T_imu_;
  SE3 odom_T_map_;                  ///< of the last estimate that has a place in the map
  std::optional<Time> last_state_;  ///< that was published
  double rate_variance_ = 0;        ///< of a sample's angular rate [rad^2/s^2]
  bool lost_ = false;

  std::mutex path_mutex_;  // of the next three; locked before mutex_
  std::deque<std::pair<Time, SE3>> path_;
  std::optional<Time> last_path_, last_points_;
};

}  // namespace chasles::ros1
