#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <chasles/bags/bag_contents.hpp>

namespace chasles {

// The SDK of a depth camera (librealsense) records messages whose header.stamp is the time of
// arrival, from 0 at the start of the recording. The time of the sensor is in a text on the topic
// `metadata` beside: "Frame number=0;timestamp_domain=Global Time;timestamp=1403636584763.555664;".

/// Whether a topic is such a text: std_msgs/String or diagnostic_msgs/KeyValue on …/metadata.
bool is_sensor_metadata(const BagTopic& topic);

/// A time of the sensor as the text has it, in a unit that is not stated.
struct SensorTime {
  Time recorded{};         ///< when the message was recorded
  std::int64_t whole = 0;  ///< of the number
  std::int64_t millionths = 0;
  std::int16_t domain = 0;  ///< which clock: the index of its name
  std::int16_t key = 0;     ///< which of the known names it had; the first are preferred
};

/// The times of all such topics of a bag.
class SensorTimes {
 public:
  /// Takes a message of such a topic; one without a time is ignored. Throws InputError if it is
  /// truncated.
  void add(const BagTopic& topic, const RosMessage& message, Time recorded);
  /// Puts the times of the sensors in the place of the stamps: of all IMU samples and images whose
  /// stamps are those of arrival, if the times of all are by one clock. Messages without a time of
  /// the sensor are left out. `remarks` receives a sentence on what was done, or why not.
  void apply(std::vector<TopicContents>& topics, std::vector<std::string>& remarks);

 private:
  struct OfTopic {
    std::vector<SensorTime> times;
    std::int16_t domain = 0;  // the last that was named
  };

  /// A topic of samples or images whose stamps are times of recording, and its times.
  struct Candidate {
    TopicContents* topic = nullptr;
    const std::vector<SensorTime>* times = nullptr;
  };

  std::vector<Candidate> candidates(std::vector<TopicContents>& topics);
  std::int16_t most_frequent_domain(const std::vector<Candidate>& candidates) const;
  void add_item(OfTopic& of, std::string_view key, std::string_view value, Time recorded);
  std::int16_t domain_of(std::string_view name);

  std::map<std::string, OfTopic> of_topics_;
  std::vector<std::string> domains_{"an unnamed clock"};
};

}  // namespace chasles
