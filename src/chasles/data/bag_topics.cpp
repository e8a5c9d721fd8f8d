#include <algorithm>

#include <fmt/format.h>

#include <chasles/data/bag_topics.hpp>
#include <chasles/data/yaml_map.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

bool is_image(const BagTopic& topic) {
  return topic.type == "sensor_msgs/Image" || topic.type == "sensor_msgs/CompressedImage";
}

bool has(const std::vector<BagTopic>& topics, const std::string& name) {
  return std::any_of(topics.begin(), topics.end(), [&](const auto& t) { return t.name == name; });
}

std::string listed(const std::vector<BagTopic>& topics) {
  std::string text;
  for (const BagTopic& t : topics)
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", t.name, t.type);
  return text.empty() ? "no topic" : text;
}

[[noreturn]] void fail(const fs::path& bag, const std::vector<BagTopic>& topics,
                       const std::string& expected) {
  throw InputError(fmt::format(
      "{}: holds {}; expected {}: choose them in a file topics.yaml beside the bag (imu: /TOPIC, "
      "cameras: [/TOPIC, ...])",
      bag.string(), listed(topics), expected));
}

ChosenTopics by_file(const fs::path& file) {
  const YamlMap map =
      YamlMap::read(file, {.known = {"imu", "cameras"}, .needed = {"imu", "cameras"}});
  return {.imu = map.text("imu"), .cameras = map.texts("cameras")};
}

ChosenTopics by_type(const fs::path& bag, const std::vector<BagTopic>& topics,
                     std::size_t cameras) {
  ChosenTopics chosen;
  std::size_t imus = 0;
  for (const BagTopic& topic : topics) {
    if (topic.type == "sensor_msgs/Imu") {
      chosen.imu = topic.name;
      ++imus;
    }
    if (!is_image(topic)) continue;
    const std::string& name = topic.name;
    const bool copy =
        name.ends_with("/compressed") && has(topics, name.substr(0, name.size() - 11));
    if (!copy) chosen.cameras.push_back(name);
  }
  if (imus != 1) fail(bag, topics, "one topic of sensor_msgs/Imu");
  if (chosen.cameras.size() != cameras) {
    fail(bag, topics,
         fmt::format("{} topic{} of images, as many as cameras are calibrated", cameras,
                     cameras == 1 ? "" : "s"));
  }
  std::sort(chosen.cameras.begin(), chosen.cameras.end());
  return chosen;
}

}  // namespace

ChosenTopics choose_topics(const fs::path& bag, const std::vector<BagTopic>& topics,
                           const KalibrCalibration& calibration) {
  const fs::path file = bag.parent_path() / "topics.yaml";
  ChosenTopics chosen{.imu = calibration.imu_topic, .cameras = calibration.camera_topics};
  const auto there = [&](const std::string& name) { return has(topics, name); };
  if (fs::exists(file)) {
    chosen = by_file(file);
  } else if (!there(chosen.imu) ||
             !std::all_of(chosen.cameras.begin(), chosen.cameras.end(), there)) {
    return by_type(bag, topics, calibration.cameras.size());
  }
  if (chosen.cameras.size() != calibration.cameras.size()) {
    fail(bag, topics, fmt::format("{} cameras", calibration.cameras.size()));
  }
  if (!there(chosen.imu)) fail(bag, topics, "the topic " + chosen.imu);
  for (const std::string& name : chosen.cameras) {
    if (!there(name)) fail(bag, topics, "the topic " + name);
  }
  return chosen;
}

}  // namespace chasles
