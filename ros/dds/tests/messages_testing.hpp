#pragma once

#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <chasles/bags/message_fields.hpp>
#include <chasles/lie/se3.hpp>

// What the bridge publishes, taken from its bytes by the fields of the .msg files.
namespace chasles::test {

inline MessageFields fields_of(const std::string& bytes) {
  static const std::string where = "message";
  return {bytes, Wire::kCdr, where};
}

template <int N>
Eigen::Matrix<double, N, N> square(MessageFields& fields) {
  Eigen::Matrix<double, N, N> matrix;
  for (int i = 0; i < N * N; ++i) matrix(i / N, i % N) = fields.number<double>();
  return matrix;
}

inline SE3 pose(MessageFields& fields) {
  const Eigen::Vector3d p = fields.vector(), xyz = fields.vector();
  return {Eigen::Quaterniond(fields.number<double>(), xyz.x(), xyz.y(), xyz.z()).toRotationMatrix(),
          p};
}

/// nav_msgs/msg/Odometry.
struct Odometry {
  Time time{};
  std::string frame, child;
  SE3 pose;
  Eigen::Matrix<double, 6, 6> pose_covariance, twist_covariance;
  Eigen::Vector3d linear, angular;
};
inline Odometry odometry(const std::string& bytes) {
  MessageFields fields = fields_of(bytes);
  const MessageHeader header = fields.header();
  Odometry o;
  o.time = header.stamp;
  o.frame = header.frame;
  o.child = fields.text();
  o.pose = pose(fields);
  o.pose_covariance = square<6>(fields);
  o.linear = fields.vector();
  o.angular = fields.vector();
  o.twist_covariance = square<6>(fields);
  return o;
}

/// px4_msgs/msg/VehicleOdometry.
struct VehicleOdometry {
  std::uint64_t timestamp = 0, timestamp_sample = 0;
  int pose_frame = 0, velocity_frame = 0, reset_counter = 0, quality = 0;
  Eigen::Vector4d q;  ///< w x y z
  Eigen::Vector3d position, velocity, angular_velocity;
  Eigen::Vector3d position_variance, orientation_variance, velocity_variance;
};
template <int N>
Eigen::Matrix<double, N, 1> floats(MessageFields& fields) {
  Eigen::Matrix<double, N, 1> values;
  for (double& value : values) value = fields.number<float>();
  return values;
}
inline VehicleOdometry vehicle_odometry(const std::string& bytes) {
  MessageFields fields = fields_of(bytes);
  VehicleOdometry o;
  o.timestamp = fields.number<std::uint64_t>();
  o.timestamp_sample = fields.number<std::uint64_t>();
  o.pose_frame = fields.number<std::uint8_t>();
  o.position = floats<3>(fields);
  o.q = floats<4>(fields);
  o.velocity_frame = fields.number<std::uint8_t>();
  o.velocity = floats<3>(fields);
  o.angular_velocity = floats<3>(fields);
  o.position_variance = floats<3>(fields);
  o.orientation_variance = floats<3>(fields);
  o.velocity_variance = floats<3>(fields);
  o.reset_counter = fields.number<std::uint8_t>();
  o.quality = fields.number<std::int8_t>();
  return o;
}

/// geometry_msgs/msg/TransformStamped.
struct Transform {
  Time time{};
  std::string parent, child;
  SE3 parent_T_child;
};
/// tf2_msgs/msg/TFMessage.
inline std::vector<Transform> transforms(const std::string& bytes) {
  MessageFields fields = fields_of(bytes);
  std::vector<Transform> all(fields.number<std::uint32_t>());
  for (Transform& t : all) {
    const MessageHeader header = fields.header();
    t.time = header.stamp;
    t.parent = header.frame;
    t.child = fields.text();
    t.parent_T_child = pose(fields);
  }
  return all;
}

/// sensor_msgs/msg/PointCloud2.
struct Cloud {
  Time time{};
  std::string frame;
  std::uint32_t height = 0, width = 0, point_step = 0, row_step = 0;
  std::map<std::string, std::uint32_t> offsets;  ///< of the fields
  std::map<std::string, int> datatypes;
  std::string data;

  template <typename Number>
  Number at(std::size_t point, const std::string& field) const {
    Number number;
    std::memcpy(&number, data.data() + point * point_step + offsets.at(field), sizeof(Number));
    return number;
  }
};
inline Cloud cloud(const std::string& bytes) {
  MessageFields fields = fields_of(bytes);
  const MessageHeader header = fields.header();
  Cloud c;
  c.time = header.stamp;
  c.frame = header.frame;
  c.height = fields.number<std::uint32_t>();
  c.width = fields.number<std::uint32_t>();
  const auto count = fields.number<std::uint32_t>();
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::string name(fields.text());
    c.offsets[name] = fields.number<std::uint32_t>();
    c.datatypes[name] = fields.number<std::uint8_t>();
    fields.number<std::uint32_t>();
  }
  fields.number<std::uint8_t>();
  c.point_step = fields.number<std::uint32_t>();
  c.row_step = fields.number<std::uint32_t>();
  c.data = fields.bytes();
  return c;
}

/// The first status of a diagnostic_msgs/msg/DiagnosticArray.
struct Status {
  int level = 0;
  std::string name, message;
  std::map<std::string, std::string> values;
};
inline Status status(const std::string& bytes) {
  MessageFields fields = fields_of(bytes);
  fields.header();
  fields.number<std::uint32_t>();
  Status s;
  s.level = fields.number<std::uint8_t>();
  s.name = fields.text();
  s.message = fields.text();
  fields.text();
  const auto count = fields.number<std::uint32_t>();
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::string key(fields.text());
    s.values[key] = fields.text();
  }
  return s;
}

}  // namespace chasles::test
