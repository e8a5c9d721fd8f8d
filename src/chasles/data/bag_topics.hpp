#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/data/kalibr.hpp>

namespace chasles {

/// A topic of a bag and the type of its messages.
struct BagTopic {
  std::string name;
  std::string type;  ///< "sensor_msgs/Imu"
};

/// The topics that make a recording.
struct ChosenTopics {
  std::string imu;
  std::vector<std::string> cameras;  ///< one for each camera of the calibration
};

/// Chooses them. First comes topics.yaml beside the bag, `imu: /TOPIC` and `cameras: [/TOPIC, …]`;
/// then the topics that Kalibr's files name, where the bag has them all; then the bag's only
/// sensor_msgs/Imu and its images in order of name, if there are as many as cameras (of a topic and
/// its /compressed the raw one). Throws InputError with what the bag has.
ChosenTopics choose_topics(const std::filesystem::path& bag, const std::vector<BagTopic>& topics,
                           const KalibrCalibration& calibration);

}  // namespace chasles
