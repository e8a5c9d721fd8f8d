#include "conversions.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <chasles/bags/ros_image.hpp>
#include <chasles/bags/ros_messages.hpp>
#include <chasles/base/error.hpp>
#include <chasles/codec/image_range.hpp>
#include <chasles/codec/numbers.hpp>

namespace chasles::ros1 {
namespace {

std::array<double, 3> array_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

std::array<double, 36> array_of(const Matrix6d& m) {
  std::array<double, 36> rows{};
  for (int i = 0; i < 36; ++i) rows[static_cast<std::size_t>(i)] = m(i / 6, i % 6);
  return rows;
}

/// Calls `raw` with a sensor_msgs/Image, or `packed` with the bytes of a PNG or a JPEG.
template <typename Raw, typename Packed>
auto visit_image(const RawMessage& message, const std::string& where, const Raw& raw,
                 const Packed& packed) {
  const RosMessage ros{.bytes = message.bytes, .wire = Wire::kRos1, .where = where};
  if (message.type == "sensor_msgs/Image") return raw(ros_image(ros));
  if (message.type == "sensor_msgs/CompressedImage") return packed(ros_compressed_image(ros));
  throw InputError(
      fmt::format("{}: the messages are {}, expected sensor_msgs/Image or "
                  "sensor_msgs/CompressedImage",
                  where, message.type));
}

}  // namespace

GrayImage image_of(const RawMessage& message, const ImageSize& expected, int bits,
                   const std::string& where) {
  return visit_image(
      message, where, [&](const RosImage& raw) { return grey_image(raw, expected, bits, where); },
      [&](std::string_view packed) { return decode_image(packed, expected, where, bits); });
}

int bits_of(const RawMessage& message, const ImageSize& expected, const std::string& where) {
  const auto find = [&](const auto& pixels) { return largest_deep_value(pixels, expected, where); };
  const std::optional<int> largest = visit_image(message, where, find, find);
  const auto range = deep_range(1, [&](std::size_t) { return largest; });
  return range ? range->bits : kAllBits;
}

OutHeader header_of(Time time, const std::string& frame) {
  const std::int64_t seconds = time.count() / 1'000'000'000;
  if (time < Time::zero() || seconds > std::numeric_limits<std::uint32_t>::max()) {
    throw InputError(
        fmt::format("{} ns is no stamp of ROS, expected a time from 1970 to 2106", time.count()));
  }
  return {.stamp = time.count(), .frame = frame};
}

OutPose pose_of(const SE3& pose) {
  const Eigen::Vector4d q = unit_quaternion(pose.R);
  return {.position = array_of(pose.p), .quaternion_xyzw = {q[0], q[1], q[2], q[3]}};
}

OutTransform transform_of(Time time, const std::string& parent, const std::string& child,
                          const SE3& parent_T_child) {
  return {.parent = header_of(time, parent), .child = child, .pose = pose_of(parent_T_child)};
}

OutPoseWithCovariance pose_with_covariance_of(Time time, const std::string& frame, const SE3& pose,
                                              const Matrix6d& covariance) {
  return {
      .header = header_of(time, frame), .pose = pose_of(pose), .covariance = array_of(covariance)};
}

OutOdometry odometry_of(Time time, const BodyState& body, const std::string& world_frame,
                        const std::string& body_frame) {
  return {
      .pose = pose_with_covariance_of(time, world_frame, body.world_T_body, body.pose_covariance),
      .child = body_frame,
      .linear = array_of(body.linear),
      .angular = array_of(body.angular),
      .twist_covariance = array_of(body.twist_covariance)};
}

OutPoints points_of(Time time, const std::string& frame, std::span<const MapLandmark> landmarks) {
  OutPoints points{.header = header_of(time, frame), .points = {}};
  points.points.reserve(landmarks.size());
  for (const MapLandmark& landmark : landmarks) {
    const Eigen::Vector3f p = landmark.p_world.cast<float>();
    points.points.push_back(
        {p.x(), p.y(), p.z(), static_cast<float>(std::sqrt(landmark.covariance.trace()))});
  }
  return points;
}

ImuMotion motion_of(const PredictedState& state, double rate_variance) {
  ImuMotion motion{.world_T_imu = state.state.world_T_imu,
                   .v_world = state.state.v_world,
                   .angular_rate_imu = state.angular_rate_imu};
  motion.covariance = state.covariance;
  motion.rate_variance = rate_variance;
  return motion;
}

// The covariance of a body at a standstill: the velocity is not asked for.
std::pair<SE3, Matrix6d> body_in_map(const PoseInMap& imu, const SE3& body_T_imu) {
  ImuMotion motion{.world_T_imu = imu.map_T_imu};
  motion.covariance.topLeftCorner<6, 6>() = imu.covariance;
  const BodyState body = body_state(motion, body_T_imu);
  return {body.world_T_body, body.pose_covariance};
}

}  // namespace chasles::ros1
