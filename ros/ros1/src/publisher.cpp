#include "publisher.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <chasles/bags/camera_info.hpp>

#include "conversions.hpp"

namespace chasles::ros1 {
namespace {

constexpr Time kLate = std::chrono::milliseconds(500);

// Whether a period has passed since `last`, which then is `now`.
bool is_due(Time now, double period, std::optional<Time>& last) {
  if (period <= 0 || (last && now - *last < from_seconds(period) && now >= *last)) return false;
  last = now;
  return true;
}

}  // namespace

Publisher::Publisher(Transport& transport, const NodeParameters& parameters)
    : transport_(transport),
      parameters_(parameters),
      imu_frame_(parameters.imu_frame),
      base_T_imu_(parameters.base_T_imu) {}

void Publisher::set_imu_frame(const std::string& frame) {
  const std::lock_guard lock(mutex_);
  if (imu_frame_.empty()) imu_frame_ = frame;
}

// As in tf2 a frame has one parent, and its last transform counts.
void Publisher::add_transforms(const std::vector<RosTransform>& transforms) {
  const std::lock_guard lock(mutex_);
  for (const RosTransform& transform : transforms) {
    const auto known = std::ranges::find(transforms_, transform.child, &RosTransform::child);
    if (known == transforms_.end()) {
      transforms_.push_back(transform);
    } else {
      *known = transform;
    }
  }
}

// Decided when the first state is published. `mutex_` is locked.
SE3 Publisher::base_T_imu() {
  if (base_T_imu_) return *base_T_imu_;
  base_T_imu_ = SE3{};
  if (imu_frame_ == parameters_.base_frame) return *base_T_imu_;
  if (const auto found = find_transform(transforms_, parameters_.base_frame, imu_frame_)) {
    base_T_imu_ = *found;
  } else {
    transport_.log(LogLevel::kWarning,
                   fmt::format("/tf_static does not lead from '{}', the frame of the IMU, to '{}': "
                               "the IMU's frame is taken for it; set ~base_T_imu or ~base_frame",
                               imu_frame_, parameters_.base_frame));
  }
  return *base_T_imu_;
}

void Publisher::publish(const PredictedState& state) {
  const std::lock_guard lock(mutex_);
  // A late sample. A state of a run that has ended, which came after the reset, is far ahead: it
  // does not silence the new run.
  const bool late = last_state_ && state.time <= *last_state_ && *last_state_ - state.time < kLate;
  if (lost_ || late) return;
  const SE3 base_T_imu = this->base_T_imu();
  // A sample's white noise falls as its interval grows.
  const double interval = last_state_ ? to_seconds(state.time - *last_state_) : 0;
  last_state_ = state.time;
  if (interval > 0) rate_variance_ = rate_noise_density_ * rate_noise_density_ / interval;
  const BodyState body = body_state(motion_of(state, rate_variance_), base_T_imu);
  transport_.publish_odometry(
      odometry_of(state.time, body, parameters_.odom_frame, parameters_.base_frame));
  if (!parameters_.publish_tf) return;
  transport_.publish_transforms({transform_of(state.time, parameters_.map_frame,
                                              parameters_.odom_frame, odom_T_map_.inverse()),
                                 transform_of(state.time, parameters_.odom_frame,
                                              parameters_.base_frame, body.world_T_body)});
}

void Publisher::publish(std::span<const Estimate> estimates, VisualInertialSlam& slam) {
  const std::lock_guard path_lock(path_mutex_);
  SE3 base_T_imu;
  double rate_variance = 0;
  {
    const std::lock_guard lock(mutex_);
    base_T_imu = this->base_T_imu();
    rate_variance = rate_variance_;
    lost_ = estimates.back().health == Health::kLost;
    if (estimates.back().in_map) odom_T_map_ = estimates.back().in_map->world_T_map;
  }
  for (const Estimate& e : estimates) {
    if (e.health == Health::kLost) return;
    publish_frame(e, slam, base_T_imu, rate_variance);
  }
  const Time now = estimates.back().time;
  publish_path(now);
  publish_points(now, slam);
}

void Publisher::publish_frame(const Estimate& e, VisualInertialSlam& slam, const SE3& base_T_imu,
                              double rate_variance) {
  ImuMotion motion{.world_T_imu = e.world_T_imu};
  motion.covariance.topLeftCorner<6, 6>() = e.pose_covariance();
  const std::string& odom = parameters_.odom_frame;
  const BodyState pose = body_state(motion, base_T_imu);
  transport_.publish_pose(
      pose_with_covariance_of(e.time, odom, pose.world_T_body, pose.pose_covariance));
  path_.emplace_back(e.time, pose.world_T_body);
  if (const auto state = slam.predicted(e.time); state && state->since_estimate == Time::zero()) {
    const BodyState body = body_state(motion_of(*state, rate_variance), base_T_imu);
    transport_.publish_frame_odometry(odometry_of(e.time, body, odom, parameters_.base_frame));
  }
  publish_place(e, base_T_imu);
}

void Publisher::publish_place(const Estimate& e, const SE3& base_T_imu) {
  if (!e.in_map) return;
  const auto [pose, covariance] = body_in_map(*e.in_map, base_T_imu);
  transport_.publish_pose_in_map(
      pose_with_covariance_of(e.time, parameters_.map_frame, pose, covariance));
}

void Publisher::publish_path(Time now) {
  while (path_.size() > static_cast<std::size_t>(parameters_.path_length)) path_.pop_front();
  if (!is_due(now, parameters_.path_period, last_path_) || !transport_.wants_path()) return;
  OutPath path{.header = header_of(now, parameters_.odom_frame), .poses = {}};
  for (const auto& [time, pose] : path_) {
    path.poses.emplace_back(header_of(time, "").stamp, pose_of(pose));
  }
  transport_.publish_path(path);
}

void Publisher::publish_points(Time now, const VisualInertialSlam& slam) {
  if (!is_due(now, parameters_.points_period, last_points_) || !transport_.wants_points()) return;
  transport_.publish_points(points_of(now, parameters_.odom_frame, slam.estimator().map()));
}

void Publisher::reset() {
  const std::lock_guard path_lock(path_mutex_);
  const std::lock_guard lock(mutex_);
  lost_ = false;
  odom_T_map_ = SE3{};
  last_state_.reset();
  path_.clear();
  last_path_.reset();
  last_points_.reset();
}

}  // namespace chasles::ros1
