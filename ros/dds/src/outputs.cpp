#include "outputs.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>

#include <Eigen/Geometry>

#include "options.hpp"

namespace chasles::bridge {
namespace {

// Those of ROS 2: tf2's broadcaster keeps 100.
constexpr Delivery kTransforms{.reliable = true, .depth = 100};
constexpr Delivery kOthers{.reliable = true, .depth = 10};

// The messages of DDS hold pointers to what may be written. Nothing writes here.
char* text(const std::string& text) { return const_cast<char*>(text.c_str()); }

std_msgs_msg_dds__Header_ header_of(const std::string& frame, Time time) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  return {.stamp = {.sec = static_cast<std::int32_t>(seconds.count()),
                    .nanosec = static_cast<std::uint32_t>((time - seconds).count())},
          .frame_id = text(frame)};
}

geometry_msgs_msg_dds__Quaternion_ quaternion(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  return {.x = q.x(), .y = q.y(), .z = q.z(), .w = q.w()};
}

geometry_msgs_msg_dds__Vector3_ vector(const Eigen::Vector3d& v) {
  return {.x = v.x(), .y = v.y(), .z = v.z()};
}

// A variance of 0, as that of the heading at the start, may be below it by rounding.
void copy(const Matrix6d& covariance, double (&row_by_row)[36]) {
  for (int i = 0; i < 36; ++i) {
    const double value = covariance(i / 6, i % 6);
    row_by_row[i] = i % 7 == 0 ? std::max(value, 0.0) : value;
  }
}

// A sequence that lends what a vector has.
template <typename Sequence, typename Element>
Sequence sequence_of(std::span<Element> elements) {
  Sequence sequence{};
  sequence._maximum = sequence._length = static_cast<std::uint32_t>(elements.size());
  sequence._buffer = elements.data();
  sequence._release = false;
  return sequence;
}

struct PointRecord {
  float x, y, z, sigma;
  std::uint32_t observations;
};
constexpr std::uint8_t kUint32 = 6, kFloat32 = 7;  // of sensor_msgs/msg/PointField

struct FieldOfPoint {
  std::string name;
  std::uint32_t offset;
  std::uint8_t datatype;
};
const std::array kFields{
    FieldOfPoint{"x", offsetof(PointRecord, x), kFloat32},
    FieldOfPoint{"y", offsetof(PointRecord, y), kFloat32},
    FieldOfPoint{"z", offsetof(PointRecord, z), kFloat32},
    FieldOfPoint{"sigma", offsetof(PointRecord, sigma), kFloat32},
    FieldOfPoint{"observations", offsetof(PointRecord, observations), kUint32},
};

std::vector<std::uint8_t> bytes_of(std::span<const MapLandmark> landmarks) {
  std::vector<std::uint8_t> bytes(landmarks.size() * sizeof(PointRecord));
  std::uint8_t* to = bytes.data();
  for (const MapLandmark& l : landmarks) {
    const PointRecord record{
        .x = static_cast<float>(l.p_world.x()),
        .y = static_cast<float>(l.p_world.y()),
        .z = static_cast<float>(l.p_world.z()),
        .sigma = static_cast<float>(std::sqrt(l.covariance.trace())),
        .observations = static_cast<std::uint32_t>(l.observations),
    };
    std::memcpy(to, &record, sizeof(record));
    to += sizeof(record);
  }
  return bytes;
}

}  // namespace

Outputs::Outputs(Participant& participant, const BridgeOptions& options)
    : frames_{.map = options.map_frame, .odom = options.odom_frame, .base = options.base_frame},
      tf_(options.tf),
      name_("chasles: " + options.robot.name),
      odometry_writer_(participant, options.odometry, kOthers),
      transform_writer_(participant, "/tf", kTransforms),
      points_writer_(participant, options.points, kOthers),
      diagnostics_writer_(participant, options.diagnostics, kOthers) {
  if (!options.px4.empty()) px4_writer_.emplace(participant, options.px4, kOthers);
}

void Outputs::odometry(const BodyState& body, Time time) {
  OdometryMessage message{};
  message.header = header_of(frames_.odom, time);
  message.child_frame_id = text(frames_.base);
  const Eigen::Vector3d& p = body.world_T_body.p;
  message.pose.pose.position = {.x = p.x(), .y = p.y(), .z = p.z()};
  message.pose.pose.orientation = quaternion(body.world_T_body.R);
  copy(body.pose_covariance, message.pose.covariance);
  message.twist.twist = {.linear = vector(body.linear), .angular = vector(body.angular)};
  copy(body.twist_covariance, message.twist.covariance);
  odometry_writer_.write(message);
  if (px4_writer_) px4_writer_->write(vehicle_odometry(body, time, quality_));
  send_transform(frames_.odom, frames_.base, body.world_T_body, time);
}

void Outputs::quality(Health health, std::size_t jumps) { quality_ = px4_quality(health, jumps); }

void Outputs::map_T_odom(const SE3& pose, Time time) {
  send_transform(frames_.map, frames_.odom, pose, time);
}

void Outputs::send_transform(const std::string& parent, const std::string& child,
                             const SE3& parent_T_child, Time time) {
  if (!tf_) return;
  geometry_msgs_msg_dds__TransformStamped_ transform{
      .header = header_of(parent, time),
      .child_frame_id = text(child),
      .transform = {.translation = vector(parent_T_child.p),
                    .rotation = quaternion(parent_T_child.R)}};
  transform_writer_.write({.transforms = sequence_of<decltype(TransformsMessage::transforms)>(
                               std::span(&transform, 1))});
}

void Outputs::points(std::span<const MapLandmark> landmarks, Time time) {
  std::vector<sensor_msgs_msg_dds__PointField_> fields;
  for (const FieldOfPoint& field : kFields) {
    fields.push_back(
        {.name = text(field.name), .offset = field.offset, .datatype = field.datatype, .count = 1});
  }
  std::vector<std::uint8_t> bytes = bytes_of(landmarks);
  PointsMessage message{};
  message.header = header_of(frames_.odom, time);
  message.height = 1;
  message.width = static_cast<std::uint32_t>(landmarks.size());
  message.fields = sequence_of<decltype(PointsMessage::fields)>(std::span(fields));
  message.point_step = sizeof(PointRecord);
  message.row_step = static_cast<std::uint32_t>(bytes.size());
  message.data = sequence_of<decltype(PointsMessage::data)>(std::span(bytes));
  message.is_dense = true;
  points_writer_.write(message);
}

void Outputs::send(RobotDiagnosis diagnosis) {
  const std::size_t dropped =
      odometry_writer_.dropped() + transform_writer_.dropped() + points_writer_.dropped();
  diagnosis.value("messages dropped for slow subscribers", dropped);
  std::vector<diagnostic_msgs_msg_dds__KeyValue_> values;
  for (const auto& [key, value] : diagnosis.values) {
    values.push_back({.key = text(key), .value = text(value)});
  }
  const std::string hardware;
  diagnostic_msgs_msg_dds__DiagnosticStatus_ status{
      .level = diagnosis.level,
      .name = text(name_),
      .message = text(diagnosis.message),
      .hardware_id = text(hardware),
      .values = sequence_of<decltype(diagnostic_msgs_msg_dds__DiagnosticStatus_::values)>(
          std::span(values))};
  const std::string no_frame;
  diagnostics_writer_.write(
      {.header = header_of(no_frame, std::chrono::system_clock::now().time_since_epoch()),
       .status = sequence_of<decltype(DiagnosticsMessage::status)>(std::span(&status, 1))});
}

}  // namespace chasles::bridge
