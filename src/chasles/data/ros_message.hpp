#pragma once

#include <string>
#include <string_view>

#include <chasles/camera/image_frame.hpp>
#include <chasles/data/image_decode.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

// The ROS 1 message types that a recording needs, decoded from the bytes in a bag: little-endian,
// fields in order, strings and arrays preceded by their length (wiki.ros.org/msg). Every length is
// checked against the bytes available; InputError starts with `where`.

/// The stamp of a message that starts with a std_msgs/Header.
Time ros_stamp(std::string_view message, const std::string& where);

/// sensor_msgs/Imu, without orientation and covariances.
ImuSample ros_imu(std::string_view message, const std::string& where);

/// sensor_msgs/Image of encoding mono8, 8UC1, bgr8 or rgb8, as grey.
GrayImage ros_image(std::string_view message, const ImageSize& expected, const std::string& where);

/// sensor_msgs/CompressedImage: a PNG or a JPEG.
GrayImage ros_compressed_image(std::string_view message, const ImageSize& expected,
                               const std::string& where);

}  // namespace chasles
