#include <chasles/bags/decompress.hpp>
#include <chasles/bags/file_bytes.hpp>
#include <chasles/bags/ros_messages.hpp>
#include <chasles/codec/numbers.hpp>

namespace chasles {
namespace {

constexpr std::size_t kLeastTransform = 60;  // bytes of a geometry_msgs/TransformStamped

MessageFields fields_of(const RosMessage& message) {
  return {message.bytes, message.wire, message.where};
}

// tf of ROS 1 had names with a slash before them.
std::string frame_name(std::string_view text) {
  if (text.starts_with('/')) text.remove_prefix(1);
  return std::string(text);
}

template <std::size_t N>
void read_numbers(MessageFields& fields, std::array<double, N>& numbers) {
  for (double& number : numbers) number = fields.number<double>();
}

}  // namespace

// CDR begins with a zero, never as zstd does.
void unpack_message(RosMessage& message, std::string& storage) {
  if (message.wire != Wire::kCdr || !message.bytes.starts_with("\x28\xb5\x2f\xfd")) return;
  storage = decompress(message.bytes, "zstd", largest_piece(), message.where);
  message.bytes = storage;
}

RosHeader ros_header(const RosMessage& message) {
  const MessageHeader header = fields_of(message).header();
  return {.stamp = header.stamp, .frame = frame_name(header.frame)};
}

ImuSample ros_imu(const RosMessage& message) {
  MessageFields fields = fields_of(message);
  ImuSample sample{.time = fields.header().stamp};
  fields.skip<double>(4 + 9);
  sample.angular_rate_imu = fields.vector();
  fields.skip<double>(9);
  sample.specific_force_imu = fields.vector();
  fields.skip<double>(9);
  return sample;
}

ImuStatement ros_imu_statement(const RosMessage& message) {
  MessageFields fields = fields_of(message);
  fields.header();
  fields.skip<double>(4 + 9);
  fields.vector();
  const bool no_rate = fields.number<double>() == -1;
  fields.skip<double>(8);
  fields.vector();
  return {.no_force = fields.number<double>() == -1, .no_rate = no_rate};
}

RosImage ros_image(const RosMessage& message) {
  MessageFields fields = fields_of(message);
  fields.header();
  RosImage image;
  image.height = fields.number<std::uint32_t>();
  image.width = fields.number<std::uint32_t>();
  image.encoding = fields.text();
  image.big_endian = fields.number<std::uint8_t>() != 0;
  image.step = fields.number<std::uint32_t>();
  image.data = fields.bytes();
  return image;
}

std::string_view ros_compressed_image(const RosMessage& message) {
  MessageFields fields = fields_of(message);
  fields.header();
  fields.text();
  return fields.bytes();
}

std::string_view ros_compressed_format(const RosMessage& message) {
  MessageFields fields = fields_of(message);
  fields.header();
  return fields.text();
}

RosCameraInfo ros_camera_info(const RosMessage& message) {
  MessageFields fields = fields_of(message);
  fields.header();
  RosCameraInfo info;
  info.height = fields.number<std::uint32_t>();
  info.width = fields.number<std::uint32_t>();
  info.distortion_model = fields.text();
  info.D.resize(fields.count(sizeof(double)));
  for (double& number : info.D) number = fields.number<double>();
  read_numbers(fields, info.K);
  read_numbers(fields, info.R);
  read_numbers(fields, info.P);
  info.binning_x = fields.number<std::uint32_t>();
  info.binning_y = fields.number<std::uint32_t>();
  info.x_offset = fields.number<std::uint32_t>();
  info.y_offset = fields.number<std::uint32_t>();
  return info;
}

std::vector<RosTransform> ros_transforms(const RosMessage& message) {
  MessageFields fields = fields_of(message);
  std::vector<RosTransform> transforms(fields.count(kLeastTransform));
  for (RosTransform& transform : transforms) {
    transform.parent = frame_name(fields.header().frame);
    transform.child = frame_name(fields.text());
    const Eigen::Vector3d p = fields.vector(), xyz = fields.vector();
    const Eigen::Vector4d xyzw(xyz.x(), xyz.y(), xyz.z(), fields.number<double>());
    const std::string where =
        message.where + ": the transform from " + transform.child + " to " + transform.parent;
    transform.parent_T_child = {checked_quaternion(where, xyzw), p};
  }
  return transforms;
}

}  // namespace chasles
