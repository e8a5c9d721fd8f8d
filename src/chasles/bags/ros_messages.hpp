#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <chasles/bags/message_fields.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

// The messages that a recording needs, of ROS 1 and of ROS 2: the same fields in the same order.
// All functions throw InputError, starting with `where`, for truncated bytes.

/// The bytes of a message, how they are serialised, and its name for messages.
struct RosMessage {
  std::string_view bytes;
  Wire wire = Wire::kRos1;
  std::string where = "message";
};

/// Decompresses a message that is compressed by itself (rosbag2's compression_mode MESSAGE, zstd)
/// into `storage`, at most largest_piece() bytes; others stay as they are.
void unpack_message(RosMessage& message, std::string& storage);

/// The stamp and frame of a message that begins with a std_msgs/Header.
struct RosHeader {
  Time stamp{};
  std::string frame;
};
RosHeader ros_header(const RosMessage& message);

/// sensor_msgs/Imu, without orientation and covariances. The numbers may be not finite.
ImuSample ros_imu(const RosMessage& message);

/// Whether the covariances of a sensor_msgs/Imu state that a part is not measured: the first
/// element is -1.
struct ImuStatement {
  bool no_force = false, no_rate = false;
};
ImuStatement ros_imu_statement(const RosMessage& message);

/// sensor_msgs/Image as it is.
struct RosImage {
  std::uint32_t height = 0, width = 0;
  std::string_view encoding;
  bool big_endian = false;
  std::size_t step = 0;  ///< bytes of a row
  std::string_view data;
};
RosImage ros_image(const RosMessage& message);

/// sensor_msgs/CompressedImage: the bytes of an image file, and what it says of their format:
/// "jpeg", "mono8; png compressed mono8", "h264".
std::string_view ros_compressed_image(const RosMessage& message);
std::string_view ros_compressed_format(const RosMessage& message);

/// sensor_msgs/CameraInfo.
struct RosCameraInfo {
  std::uint32_t height = 0, width = 0;
  std::string distortion_model;
  std::vector<double> D;
  std::array<double, 9> K{}, R{};
  std::array<double, 12> P{};
  std::uint32_t binning_x = 0, binning_y = 0;
  std::uint32_t x_offset = 0, y_offset = 0;  ///< of the region of interest
};
RosCameraInfo ros_camera_info(const RosMessage& message);

/// geometry_msgs/TransformStamped: p_parent = parent_T_child p_child.
struct RosTransform {
  std::string parent, child;
  SE3 parent_T_child;
};
/// tf2_msgs/TFMessage. Throws InputError too for a quaternion that is not of unit length.
std::vector<RosTransform> ros_transforms(const RosMessage& message);

}  // namespace chasles
