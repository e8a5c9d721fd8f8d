#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/bags/bag_contents.hpp>
#include <chasles/bags/image_copies.hpp>
#include <chasles/calibration/kalibr.hpp>

namespace chasles {

/// The topics that make a recording.
struct ChosenTopics {
  const TopicContents* imu = nullptr;
  /// Where the accelerometer has a topic of its own: that one, and `imu` is the gyroscope's.
  const TopicContents* accelerometer = nullptr;
  std::vector<const TopicContents*> cameras;
  /// For each of them its camera of the calibration: its number in the chain. Without a calibration
  /// the numbers are 0, 1, ….
  std::vector<std::size_t> chain;
  std::vector<std::string> remarks;
};

/// Throws InputError if there are messages, and none is serialised in a way that is read: those of
/// ROS 1 and CDR of ROS 2.
void check_serialisation(const std::string& bag, const std::vector<TopicContents>& topics);

/// Chooses the topics of a bag, in this order of preference:
///
/// 1. topics.yaml in one of the `folders`: `imu: /TOPIC`, or `imu: [/TOPIC, /TOPIC]` for
///    accelerometer and gyroscope, in either order; and `cameras: [/TOPIC, …]`, one for each camera
///    of the calibration;
/// 2. those that the calibration names. A topic and its compressed copy (/compressed) are the same
///    images: the raw ones are preferred, unless the other topic has considerably more images
///    (image_copies.hpp). A camera whose topic is not there is left out, with a remark;
/// 3. where the calibration names none of the bag's topics: the only IMU, and the only topic of
///    images for the only camera; or topics with the names of the cameras in them (/cam0/…).
///
/// A topic that measures only one part of an IMU needs another one for the rest (bag_imu.hpp). It
/// is the only such topic, or the one whose name goes with it. A topic that measures both is
/// preferred.
///
/// Of topics.yaml the first `cameras` cameras count. Nothing else is assumed. Without a calibration
/// (`kalibr` is null) the topics of images are all of them, if there are one or two. Throws
/// InputError with the topics of the bag and of the calibration, and for a video, with how to
/// convert it.
ChosenTopics choose_topics(const std::string& bag, const std::vector<TopicContents>& topics,
                           const KalibrCalibration* kalibr,
                           const std::vector<std::filesystem::path>& folders,
                           std::size_t cameras = kAllCameras);

}  // namespace chasles
