#include <algorithm>

#include <fmt/format.h>

#include <chasles/bags/bag_imu.hpp>
#include <chasles/bags/bag_topics.hpp>
#include <chasles/base/error.hpp>
#include <chasles/codec/yaml_map.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOneImu =
    "one topic of sensor_msgs/Imu, or two, of its accelerometer and its gyroscope (imu: "
    "[/ACCELEROMETER, /GYROSCOPE])";

std::string without_slash(const std::string& name) {
  return name.starts_with('/') ? name.substr(1) : name;
}

std::string topic_list(const std::vector<TopicContents>& topics) {
  constexpr std::size_t kMostListed = 100;
  std::string text;
  for (std::size_t i = 0; i < std::min(topics.size(), kMostListed); ++i) {
    const BagTopic& t = topics[i].topic;
    text += fmt::format("{}{:.100} ({:.100})", text.empty() ? "" : ", ", t.name,
                        t.type.empty() ? "of unknown type" : t.type);
  }
  if (topics.size() > kMostListed) text += fmt::format(" and {} more", topics.size() - kMostListed);
  return text.empty() ? "no message" : text;
}

std::string camera_list(const KalibrCalibration& kalibr) {
  std::string text;
  for (std::size_t c = 0; c < kalibr.cameras.size(); ++c) {
    const std::string& topic = kalibr.camera_topics[c];
    text += fmt::format("{}cam{}{}", text.empty() ? "" : ", ", c,
                        topic.empty() ? "" : fmt::format(" ({})", topic));
  }
  return text;
}

class TopicChoice {
 public:
  TopicChoice(const std::string& bag, const std::vector<TopicContents>& topics,
              const KalibrCalibration* kalibr)
      : bag_(bag), topics_(topics), kalibr_(kalibr) {
    for (const TopicContents& topic : topics) {
      if (is_of(topic, "sensor_msgs/Imu")) imus_.push_back(&topic);
      if (!is_readable_image(topic)) continue;
      // Of a topic and its compressed copy the raw one; take_camera() compares them.
      const auto raw = [&](const TopicContents& other) {
        return other.topic.name == raw_topic(topic.topic.name) && is_readable_image(other);
      };
      const bool copy = raw_topic(topic.topic.name) != topic.topic.name &&
                        std::any_of(topics.begin(), topics.end(), raw);
      if (!copy) images_.push_back(&topic);
    }
  }

  void by_file(const fs::path& file, std::size_t cameras) {
    const YamlMap map =
        YamlMap::read(file, {.known = {"imu", "cameras"}, .needed = {"imu", "cameras"}});
    take_imus_of(file, map);
    std::vector<std::string> names = map.texts("cameras");
    names.resize(std::min(names.size(), cameras));
    if (names.empty() ||
        (kalibr_ != nullptr && names.size() != std::min(kalibr_->cameras.size(), cameras))) {
      fail(fmt::format("{} cameras as in the calibration, but {} has {}",
                       kalibr_ != nullptr ? kalibr_->cameras.size() : 1, file.string(),
                       names.size()));
    }
    std::vector<const TopicContents*> all;
    for (const TopicContents& topic : topics_) {
      if (is_image(topic) || video_kind(topic)) all.push_back(&topic);
    }
    for (const std::string& name : names) {
      const TopicContents* topic = named(file, name, all, "sensor_msgs/Image or CompressedImage");
      if (video_kind(*topic)) reject_video(*topic);
      take_exactly(topic, chosen_.cameras.size());
    }
  }

  void by_calibration() {
    choose_imu(kalibr_ != nullptr ? kalibr_->imu_topic : "");
    if (images_.empty()) {
      if (const TopicContents* video = video_of("")) reject_video(*video);
      fail("a topic of sensor_msgs/Image or CompressedImage");
    }
    if (kalibr_ == nullptr) {
      take_all();
    } else {
      take_named();
      if (chosen_.cameras.empty()) take_by_camera_name();
      if (chosen_.cameras.empty()) take_only();
      remark_on_the_rest();
    }
  }

  ChosenTopics chosen() { return std::move(chosen_); }

 private:
  [[noreturn]] void fail(const std::string& expected) const {
    throw InputError(fmt::format(
        "{}: holds {}; {}expected {}: choose them in a file topics.yaml beside the bag (imu: "
        "/TOPIC, cameras: [/TOPIC, ...])",
        bag_, topic_list(topics_),
        kalibr_ == nullptr ? "" : "the calibration has " + camera_list(*kalibr_) + "; ", expected));
  }

  [[noreturn]] void reject_video(const TopicContents& topic) const {
    throw InputError(fmt::format("{}: {}", bag_, video_rejection(topic)));
  }

  // A video with the images of this topic, or (without a name) any video.
  const TopicContents* video_of(const std::string& name) const {
    const std::string images = without_slash(images_topic(name));
    for (const TopicContents& topic : topics_) {
      const bool same = without_slash(images_topic(topic.topic.name)) == images;
      if ((name.empty() || same) && video_kind(topic)) return &topic;
    }
    return nullptr;
  }

  const TopicContents* named(const fs::path& file, const std::string& name,
                             const std::vector<const TopicContents*>& of,
                             const std::string& type) const {
    for (const TopicContents* topic : of) {
      if (without_slash(topic->topic.name) == without_slash(name)) return topic;
    }
    fail(fmt::format("the topic {} of {} as {} states", name, type, file.string()));
  }

  void take_exactly(const TopicContents* topic, std::size_t chain) {
    chosen_.cameras.push_back(topic);
    chosen_.chain.push_back(chain);
  }
  // The topic, or its copy with more images.
  void take_camera(const TopicContents* topic, std::size_t chain) {
    take_exactly(fullest_copy(topics_, *topic, chosen_.remarks), chain);
  }

  void take_imus_of(const fs::path& file, const YamlMap& map) {
    std::vector<const TopicContents*> topics;
    for (const std::string& name : map.texts_or_text("imu")) {
      topics.push_back(named(file, name, imus_, "sensor_msgs/Imu"));
    }
    if (topics.size() == 1) return take_imu(topics.front());
    if (topics.size() != 2) {
      fail(fmt::format("one topic of an IMU, or two, in {}, which has {}", file.string(),
                       topics.size()));
    }
    if (measured_parts(*topics[0]) == ImuParts::kRates ||
        measured_parts(*topics[1]) == ImuParts::kForces) {
      std::swap(topics[0], topics[1]);
    }
    if (measured_parts(*topics[0]) == ImuParts::kRates ||
        measured_parts(*topics[1]) == ImuParts::kForces || topics[0] == topics[1]) {
      fail(fmt::format("an accelerometer and a gyroscope as imu of {}, but {} has {} and {} has {}",
                       file.string(), topics[0]->topic.name, parts_text(measured_parts(*topics[0])),
                       topics[1]->topic.name, parts_text(measured_parts(*topics[1]))));
    }
    chosen_.accelerometer = topics[0];
    chosen_.imu = topics[1];
  }

  // With the topic of the other sensor, if it has one alone.
  void take_imu(const TopicContents* topic) {
    const ImuParts parts = measured_parts(*topic);
    chosen_.imu = topic;
    if (parts == ImuParts::kBoth) return;
    const bool forces = parts == ImuParts::kForces;
    const TopicContents* partner =
        partner_of(*topic, imus_with(forces ? ImuParts::kRates : ImuParts::kForces));
    if (partner == nullptr) {
      fail(
          fmt::format("a topic with both parts of an IMU, or two: {} has {}, and {} topic has {} "
                      "(imu: [/ACCELEROMETER, /GYROSCOPE] chooses two)",
                      topic->topic.name, parts_text(parts),
                      imus_.size() > 1 ? "not exactly one other" : "no other",
                      forces ? "angular rates" : "accelerations"));
    }
    chosen_.accelerometer = forces ? topic : partner;
    chosen_.imu = forces ? partner : topic;
  }

  std::vector<const TopicContents*> imus_with(ImuParts parts) const {
    std::vector<const TopicContents*> found;
    for (const TopicContents* topic : imus_) {
      if (stated_parts(*topic) == parts) found.push_back(topic);
    }
    return found;
  }

  void choose_imu(const std::string& name) {
    for (const TopicContents* topic : imus_) {
      if (without_slash(topic->topic.name) == without_slash(name)) return take_imu(topic);
    }
    if (imus_.size() == 1) {
      take_imu(imus_.front());
    } else {
      take_one_or_a_pair();
    }
    if (name.empty()) return;
    chosen_.remarks.push_back(fmt::format(
        "the bag has no topic {}: the samples are those of {}{}", name,
        chosen_.accelerometer == nullptr ? "" : chosen_.accelerometer->topic.name + " and ",
        chosen_.imu->topic.name));
  }

  // Of several the only one that measures both, or a pair.
  void take_one_or_a_pair() {
    const auto both = imus_with(ImuParts::kBoth), rates = imus_with(ImuParts::kRates),
               forces = imus_with(ImuParts::kForces);
    if (both.size() == 1) {
      chosen_.imu = both.front();
      return;
    }
    if (both.empty() && rates.size() == 1) {
      chosen_.imu = rates.front();
      chosen_.accelerometer = partner_of(*rates.front(), forces);
    } else if (both.empty() && forces.size() == 1) {
      chosen_.imu = partner_of(*forces.front(), rates);
      chosen_.accelerometer = forces.front();
    }
    if (chosen_.imu == nullptr || chosen_.accelerometer == nullptr) fail(kOneImu);
  }

  // The topic that a calibration names, or its raw or compressed copy.
  const TopicContents* copy_of(const std::string& name) const {
    if (name.empty()) return nullptr;
    const TopicContents* found = nullptr;
    for (const TopicContents& topic : topics_) {
      if (!is_readable_image(topic)) continue;
      if (without_slash(topic.topic.name) == without_slash(name)) return &topic;
      if (without_slash(raw_topic(topic.topic.name)) != without_slash(raw_topic(name))) continue;
      if (found == nullptr || topic.topic.type == "sensor_msgs/Image") found = &topic;
    }
    return found;
  }

  void take_named() {
    for (std::size_t c = 0; c < kalibr_->cameras.size(); ++c) {
      if (const TopicContents* topic = copy_of(kalibr_->camera_topics[c])) take_camera(topic, c);
    }
    if (!chosen_.cameras.empty()) return;
    for (const std::string& name : kalibr_->camera_topics) {
      const TopicContents* video = name.empty() ? nullptr : video_of(name);
      if (video != nullptr) reject_video(*video);
    }
  }

  // /cam0/image_raw is cam0's.
  void take_by_camera_name() {
    for (std::size_t c = 0; c < kalibr_->cameras.size(); ++c) {
      const std::string part = fmt::format("/cam{}/", c);
      std::vector<const TopicContents*> found;
      for (const TopicContents* topic : images_) {
        if (("/" + topic->topic.name + "/").find(part) != std::string::npos) found.push_back(topic);
      }
      if (found.size() != 1) continue;
      take_camera(found.front(), c);
      if (kalibr_->camera_topics[c].empty()) continue;
      chosen_.remarks.push_back(
          fmt::format("the bag has no topic {}: the images of cam{} are "
                      "those of {}",
                      kalibr_->camera_topics[c], c, found.front()->topic.name));
    }
  }

  void take_only() {
    if (images_.size() != 1 || kalibr_->cameras.size() != 1) {
      fail("topics of images with the names that the calibration has");
    }
    take_camera(images_.front(), 0);
    if (kalibr_->camera_topics[0].empty()) return;
    chosen_.remarks.push_back(fmt::format("the bag has no topic {}: the images are those of {}",
                                          kalibr_->camera_topics[0], images_.front()->topic.name));
  }

  void take_all() {
    if (images_.size() > 2) fail("one or two topics of images");
    for (const TopicContents* topic : images_) take_camera(topic, chosen_.cameras.size());
  }

  void remark_on_the_rest() {
    for (std::size_t c = 0; c < kalibr_->cameras.size(); ++c) {
      const auto& chain = chosen_.chain;
      if (std::find(chain.begin(), chain.end(), c) != chain.end()) continue;
      const std::string& name = kalibr_->camera_topics[c];
      const TopicContents* video = name.empty() ? nullptr : video_of(name);
      chosen_.remarks.push_back(
          video != nullptr
              ? fmt::format("cam{} of the calibration is left out: {}", c, video_rejection(*video))
              : fmt::format("cam{} of the calibration is left out: the bag, which holds {}, has no "
                            "images of {}",
                            c, topic_list(topics_), name.empty() ? fmt::format("cam{}", c) : name));
    }
  }

  const std::string& bag_;
  const std::vector<TopicContents>& topics_;
  const KalibrCalibration* kalibr_;
  std::vector<const TopicContents*> imus_, images_;
  ChosenTopics chosen_;
};

}  // namespace

void check_serialisation(const std::string& bag, const std::vector<TopicContents>& topics) {
  const auto foreign = [](const TopicContents& topic) { return topic.topic.wire == Wire::kOther; };
  if (topics.empty() || !std::ranges::all_of(topics, foreign)) return;
  const BagTopic& first = topics.front().topic;
  throw InputError(fmt::format(
      "{}: its messages are serialised as {} ({:.100} of {:.100}), expected those of ROS 1 or of "
      "ROS 2 (cdr): write the images and samples as ROS messages, or as a folder of images with "
      "imu.csv (docs/formats.md)",
      bag, first.encoding.empty() ? "an unknown format" : first.encoding, first.name, first.type));
}

ChosenTopics choose_topics(const std::string& bag, const std::vector<TopicContents>& topics,
                           const KalibrCalibration* kalibr, const std::vector<fs::path>& folders,
                           std::size_t cameras) {
  check_serialisation(bag, topics);
  TopicChoice choice(bag, topics, kalibr);
  const auto file = std::find_if(folders.begin(), folders.end(), [](const fs::path& folder) {
    return fs::exists(folder / "topics.yaml");
  });
  if (file != folders.end()) {
    choice.by_file(*file / "topics.yaml", cameras);
  } else {
    choice.by_calibration();
  }
  return choice.chosen();
}

}  // namespace chasles
