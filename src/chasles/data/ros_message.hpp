#pragma once

#include <string>
#include <string_view>

#include <chasles/camera/image_frame.hpp>
#include <chasles/data/image_decode.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

// The messages of ROS 1 that a recording needs, by their bytes as a bag holds them: little-endian,
// fields in order, texts and arrays behind their length (wiki.ros.org/msg). Every length is held
// against what is there: InputError that begins with `where`.

/// The stamp of a message that begins with a std_msgs/Header.
Time ros_stamp(std::string_view message, const std::string& where);

/// sensor_msgs/Imu, without orientation and covariances.
ImuSample ros_imu(std::string_view message, const std::string& where);

/// sensor_msgs/Image of encoding mono8, 8UC1, bgr8 or rgb8, as grey.
GrayImage ros_image(std::string_view message, const ImageSize& expected, const std::string& where);

/// sensor_msgs/CompressedImage: a PNG or a JPEG.
GrayImage ros_compressed_image(std::string_view message, const ImageSize& expected,
                               const std::string& where);

}  // namespace chasles
