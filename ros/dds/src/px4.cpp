#include "px4.hpp"

#include <algorithm>
#include <chrono>

#include <Eigen/Geometry>

namespace chasles::bridge {
namespace {

constexpr std::uint8_t kPoseFrd = 2;      // POSE_FRAME_FRD: any heading is forward
constexpr std::uint8_t kVelocityFrd = 3;  // VELOCITY_FRAME_BODY_FRD

// From x forward, y left, z up, and back.
const Eigen::Matrix3d kFrd = Eigen::Vector3d(1, -1, -1).asDiagonal();

template <std::size_t N>
void copy_floats(const Eigen::VectorXd& values, float (&to)[N]) {
  std::ranges::transform(values, to, [](double value) { return static_cast<float>(value); });
}

// A variance of 0 may be below it by rounding.
Eigen::VectorXd variances(const Eigen::Matrix3d& covariance) {
  return covariance.diagonal().cwiseMax(0);
}

}  // namespace

Px4Quality px4_quality(Health health, std::size_t jumps) {
  constexpr std::int8_t kOk = 100, kDegraded = 50;
  return {.resets = static_cast<std::uint8_t>(jumps % 256),
          .percent = health == Health::kOk ? kOk : kDegraded};
}

VehicleOdometryMessage vehicle_odometry(const BodyState& body, Time time,
                                        const Px4Quality& quality) {
  const Eigen::Matrix3d& R = body.world_T_body.R;
  const Eigen::Quaterniond q(Eigen::Matrix3d(kFrd * R * kFrd));
  VehicleOdometryMessage message{};
  message.timestamp = message.timestamp_sample =
      static_cast<std::uint64_t>(std::chrono::floor<std::chrono::microseconds>(time).count());
  message.pose_frame = kPoseFrd;
  copy_floats(kFrd * body.world_T_body.p, message.position);
  copy_floats(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()), message.q);
  message.velocity_frame = kVelocityFrd;
  copy_floats(kFrd * body.linear, message.velocity);
  copy_floats(kFrd * body.angular, message.angular_velocity);
  // The signs of the axes do not count in variances.
  copy_floats(variances(body.pose_covariance.topLeftCorner<3, 3>()), message.position_variance);
  copy_floats(variances(R.transpose() * body.pose_covariance.bottomRightCorner<3, 3>() * R),
              message.orientation_variance);
  copy_floats(variances(body.twist_covariance.topLeftCorner<3, 3>()), message.velocity_variance);
  message.reset_counter = quality.resets;
  message.quality = quality.percent;
  return message;
}

}  // namespace chasles::bridge
