#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <chasles/bags/bag_file.hpp>
#include <chasles/bags/moving_transforms.hpp>
#include <chasles/bags/ros_messages.hpp>

namespace chasles {

/// Where an image is in the files of a bag.
struct BagImage {
  Time time{};  ///< header.stamp
  std::size_t file = 0;
  MessagePlace place = {};
};

/// What one topic has for a recording. A topic of another type has only its name.
struct TopicContents {
  BagTopic topic;
  std::size_t messages = 0;
  std::size_t unset = 0;       ///< messages whose header.stamp is 0: they are left out
  std::string frame = {};      ///< header.frame_id of the first message
  std::vector<ImuSample> imu;  ///< in the order of the files, with samples that are not finite
  /// Whether the covariances of all messages state that the force, or the rate, is not measured.
  bool no_force = true, no_rate = true;
  std::vector<BagImage> images;  ///< in the order of the files
  std::string encoding = {};     ///< of the first sensor_msgs/Image
  std::string format = {};       ///< of the first sensor_msgs/CompressedImage
  int width = 0, height = 0;     ///< of the first image; 0 if it could not be decoded [px]
  std::optional<RosCameraInfo> info = {};  ///< the first one
  std::string damage = {};                 ///< on the first message that could not be decoded
};

/// What the files of a bag have for a recording, found in one pass.
struct BagContents {
  std::vector<std::shared_ptr<const BagFile>> files;  ///< for reading the images
  std::vector<TopicContents> topics;                  ///< in order of name
  std::vector<RosTransform> transforms;               ///< of /tf_static, each once
  std::vector<MovingTransform> moving;                ///< of /tf
  std::vector<std::string> remarks;
};

/// Whether the topic is one of a type, "sensor_msgs/Imu".
bool is_of(const TopicContents& topic, const std::string& type);
bool is_image(const TopicContents& topic);  ///< raw or compressed

/// A file of a bag, and where it came from.
struct OpenBag {
  std::filesystem::path path;
  std::shared_ptr<BagFile> file;
};

/// Opens the files of one recording. Throws InputError for what is no bag.
std::vector<OpenBag> open_bags(const std::vector<std::filesystem::path>& files);

/// Scans them. Their messages may overlap in time. The stamps that the SDK of a depth camera writes
/// are replaced by the times of its sensors (sensor_times.hpp). Throws InputError for a damaged
/// file, and where more than a minute lies between two files: they are not of one recording.
BagContents scan_open_bags(const std::vector<OpenBag>& bags);
/// Both.
BagContents scan_bags(const std::vector<std::filesystem::path>& files);

}  // namespace chasles
