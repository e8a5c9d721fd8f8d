#include "ros_messages.hpp"

#include <algorithm>
#include <cstring>

namespace chasles::ros1 {
namespace {

std_msgs::Header header_of(std::int64_t stamp, const std::string& frame) {
  constexpr std::int64_t kSecond = 1000000000;
  std_msgs::Header header;
  header.stamp.sec = static_cast<std::uint32_t>(stamp / kSecond);
  header.stamp.nsec = static_cast<std::uint32_t>(stamp % kSecond);
  header.frame_id = frame;
  return header;
}

std_msgs::Header header_of(const OutHeader& header) {
  return header_of(header.stamp, header.frame);
}

template <typename Vector>
void set_vector(const std::array<double, 3>& from, Vector& to) {
  to.x = from[0];
  to.y = from[1];
  to.z = from[2];
}

geometry_msgs::Quaternion quaternion_of(const std::array<double, 4>& xyzw) {
  geometry_msgs::Quaternion q;
  q.x = xyzw[0];
  q.y = xyzw[1];
  q.z = xyzw[2];
  q.w = xyzw[3];
  return q;
}

geometry_msgs::Pose pose_of(const OutPose& pose) {
  geometry_msgs::Pose message;
  set_vector(pose.position, message.position);
  message.orientation = quaternion_of(pose.quaternion_xyzw);
  return message;
}

}  // namespace

geometry_msgs::PoseWithCovarianceStamped message_of(const OutPoseWithCovariance& pose) {
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header = header_of(pose.header);
  message.pose.pose = pose_of(pose.pose);
  std::copy(pose.covariance.begin(), pose.covariance.end(), message.pose.covariance.begin());
  return message;
}

nav_msgs::Odometry message_of(const OutOdometry& odometry) {
  const geometry_msgs::PoseWithCovarianceStamped pose = message_of(odometry.pose);
  nav_msgs::Odometry message;
  message.header = pose.header;
  message.child_frame_id = odometry.child;
  message.pose = pose.pose;
  set_vector(odometry.linear, message.twist.twist.linear);
  set_vector(odometry.angular, message.twist.twist.angular);
  std::copy(odometry.twist_covariance.begin(), odometry.twist_covariance.end(),
            message.twist.covariance.begin());
  return message;
}

nav_msgs::Path message_of(const OutPath& path) {
  nav_msgs::Path message;
  message.header = header_of(path.header);
  message.poses.reserve(path.poses.size());
  for (const auto& [stamp, pose] : path.poses) {
    message.poses.emplace_back();
    message.poses.back().header = header_of(stamp, path.header.frame);
    message.poses.back().pose = pose_of(pose);
  }
  return message;
}

sensor_msgs::PointCloud2 message_of(const OutPoints& points) {
  sensor_msgs::PointCloud2 message;
  message.header = header_of(points.header);
  message.height = 1;
  message.width = static_cast<std::uint32_t>(points.points.size());
  message.is_dense = 1;
  for (const char* name : {"x", "y", "z", "sigma"}) {
    sensor_msgs::PointField field;
    field.name = name;
    field.offset = static_cast<std::uint32_t>(sizeof(float) * message.fields.size());
    field.datatype = sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    message.fields.push_back(field);
  }
  message.point_step = 4 * sizeof(float);
  message.row_step = message.point_step * message.width;
  message.data.resize(message.row_step);
  if (!points.points.empty()) {
    std::memcpy(message.data.data(), points.points.data(), message.data.size());
  }
  return message;
}

tf2_msgs::TFMessage message_of(const std::vector<OutTransform>& transforms) {
  tf2_msgs::TFMessage message;
  for (const OutTransform& transform : transforms) {
    geometry_msgs::TransformStamped one;
    one.header = header_of(transform.parent);
    one.child_frame_id = transform.child;
    set_vector(transform.pose.position, one.transform.translation);
    one.transform.rotation = quaternion_of(transform.pose.quaternion_xyzw);
    message.transforms.push_back(one);
  }
  return message;
}

diagnostic_msgs::DiagnosticArray message_of(const OutDiagnosis& diagnosis, const std::string& name,
                                            const ros::Time& now) {
  diagnostic_msgs::DiagnosticArray message;
  message.header.stamp = now;
  message.status.emplace_back();
  diagnostic_msgs::DiagnosticStatus& status = message.status.back();
  status.level =
      diagnosis.level == DiagnosisLevel::kError     ? diagnostic_msgs::DiagnosticStatus::ERROR
      : diagnosis.level == DiagnosisLevel::kWarning ? diagnostic_msgs::DiagnosticStatus::WARN
                                                    : diagnostic_msgs::DiagnosticStatus::OK;
  status.name = name;
  status.message = diagnosis.message;
  for (const auto& [key, value] : diagnosis.values) {
    status.values.emplace_back();
    status.values.back().key = key;
    status.values.back().value = value;
  }
  return message;
}

}  // namespace chasles::ros1
