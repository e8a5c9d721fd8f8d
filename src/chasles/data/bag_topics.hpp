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

/// Chooses the topics, in this order of preference:
///
/// 1. topics.yaml beside the bag: `imu: /TOPIC` and `cameras: [/TOPIC, …]`; 2. the topics that
/// Kalibr's files name, if the bag has all of them; 3. the only sensor_msgs/Imu topic, and the
/// image topics in order of name, if there are as many as cameras. The raw topic has precedence
/// over its /compressed one.
///
/// Throws InputError with the topics of the bag.
ChosenTopics choose_topics(const std::filesystem::path& bag, const std::vector<BagTopic>& topics,
                           const KalibrCalibration& calibration);

}  // namespace chasles
