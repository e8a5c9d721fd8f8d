#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

#include <chasles/bags/bag_contents.hpp>
#include <chasles/bags/file_bytes.hpp>
#include <chasles/bags/image_copies.hpp>
#include <chasles/bags/packed_file.hpp>
#include <chasles/bags/sensor_times.hpp>
#include <chasles/base/error.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/codec/parse.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr Time kLongestBreak = std::chrono::minutes(1);
constexpr std::size_t kMostTransforms = 10'000;
constexpr std::size_t kLongestFormat = 100;

/// The times of recording of a file.
struct FileSpan {
  fs::path file;
  Time begin = Time::max(), end = Time::min();
};

/// Where the messages of a topic of one file go.
struct ScanTarget {
  TopicContents* topic = nullptr;
  RosMessage message = {};  // the one that is read
};

/// The topics, by name and type.
using TopicMap = std::map<std::pair<std::string, std::string>, TopicContents>;

/// The transforms between frames. As in tf2 a frame has one parent, and its last transform counts.
class StaticTransforms {
 public:
  void add(RosTransform&& one, const std::string& where) {
    if (const auto known = of_child_.find(one.child); known != of_child_.end()) {
      all[known->second] = std::move(one);
      return;
    }
    if (all.size() == kMostTransforms) {
      throw InputError(
          fmt::format("{}: has more than {} static transforms", where, kMostTransforms));
    }
    of_child_[one.child] = all.size();
    all.push_back(std::move(one));
  }
  std::vector<RosTransform> all;

 private:
  std::map<std::string, std::size_t> of_child_;
};

void note_image(const RosMessage& message, TopicContents& topic) {
  if (topic.images.size() > 1) return;
  if (topic.topic.type == "sensor_msgs/CompressedImage") {
    topic.format = ros_compressed_format(message).substr(0, kLongestFormat);
    const ImageSize size = stated_size(ros_compressed_image(message), message.where);
    topic.width = size.width;
    topic.height = size.height;
    return;
  }
  const RosImage image = ros_image(message);
  topic.encoding = image.encoding;
  // A larger size is none that a calibration has.
  topic.width = static_cast<int>(std::min(image.width, 1u << 30));
  topic.height = static_cast<int>(std::min(image.height, 1u << 30));
}

// An image that is damaged is one that cannot be read later; here it gives no figures.
void add_image(const RosMessage& message, const BagImage& image, TopicContents& topic) {
  topic.images.push_back(image);
  try {
    note_image(message, topic);
  } catch (const InputError&) {
  }
}

bool is_moving(const BagTopic& topic) {
  return (topic.type == "tf2_msgs/TFMessage" || topic.type == "tf/tfMessage") &&
         (topic.name == "tf" || topic.name.ends_with("/tf"));
}

bool is_read(const BagTopic& topic) {
  return topic.wire != Wire::kOther &&
         (topic.type.starts_with("sensor_msgs/") || topic.name.ends_with("tf_static") ||
          is_moving(topic) || is_sensor_metadata(topic) || is_video_type(topic.type));
}

void take_message(const RosMessage& message, const BagImage& place, TopicContents& topic,
                  StaticTransforms& transforms) {
  if (topic.topic.type == "tf2_msgs/TFMessage" || topic.topic.type == "tf/tfMessage") {
    for (RosTransform& one : ros_transforms(message)) transforms.add(std::move(one), message.where);
    return;
  }
  if (is_video_type(topic.topic.type)) {
    if (topic.messages == 1) topic.format = packet_format(topic.topic.type, message);
    return;
  }
  const bool image = is_image(topic), imu = is_of(topic, "sensor_msgs/Imu");
  const bool info = is_of(topic, "sensor_msgs/CameraInfo") && !topic.info;
  if (!image && !imu && !info) return;
  const RosHeader header = ros_header(message);
  if (topic.frame.empty()) topic.frame = header.frame;
  if (info) {
    topic.info = ros_camera_info(message);
  } else if (header.stamp == Time{}) {
    ++topic.unset;
  } else if (imu) {
    const ImuStatement states = ros_imu_statement(message);
    topic.no_force = topic.no_force && states.no_force;
    topic.no_rate = topic.no_rate && states.no_rate;
    topic.imu.push_back(ros_imu(message));
  } else {
    add_image(message, {.time = header.stamp, .file = place.file, .place = place.place}, topic);
  }
}

class BagScan {
 public:
  void scan(const OpenBag& bag, BagContents& contents) {
    const fs::path& path = bag.path;
    const std::size_t number = contents.files.size();
    FileSpan span{.file = path};
    std::error_code ignored;
    unpacked_ = 0;
    budget_ = most_unpacked(fs::file_size(path, ignored));
    targets_.clear();
    if (const std::string_view packed = packed_as_file(path); !packed.empty()) {
      contents.remarks.push_back(
          fmt::format("{} is compressed as a whole ({}): unpacked into a temporary file",
                      path.string(), packed));
    }
    bag.file->scan(
        [&](const BagMessage& message) {
          const Time recorded = std::clamp(message.recorded, Time{}, Time(kLastNanosecond));
          span.begin = std::min(span.begin, recorded);
          span.end = std::max(span.end, recorded);
          take(message, path, {.time = recorded, .file = number, .place = message.place});
        },
        contents.remarks);
    if (span.begin <= span.end) spans_.push_back(span);
    contents.files.push_back(bag.file);
  }

  // The longest time without a message between two files, after the end of all files before.
  void check_breaks() {
    std::sort(spans_.begin(), spans_.end(),
              [](const FileSpan& a, const FileSpan& b) { return a.begin < b.begin; });
    for (std::size_t i = 1; i < spans_.size(); ++i) {
      if (spans_[i].begin - spans_[i - 1].end > kLongestBreak) {
        throw InputError(fmt::format(
            "{}: begins {:.0f} s after the end of {} beside it, expected the bags of one recording "
            "in a folder: name one of the files, or move the others away",
            spans_[i].file.string(), to_seconds(spans_[i].begin - spans_[i - 1].end),
            spans_[i - 1].file.filename().string()));
      }
      spans_[i].end = std::max(spans_[i].end, spans_[i - 1].end);
    }
  }

  void move_to(BagContents& contents) {
    for (auto& [name, topic] : topics_) contents.topics.push_back(std::move(topic));
    contents.transforms = std::move(transforms_.all);
    contents.moving = std::move(moving_.all);
    sensor_times_.apply(contents.topics, contents.remarks);
  }

 private:
  void take(const BagMessage& message, const fs::path& path, const BagImage& place) {
    ScanTarget& target = target_of(*message.topic, path);
    TopicContents& topic = *target.topic;
    ++topic.messages;
    if (!is_read(*message.topic)) return;
    target.message.bytes = message.bytes;
    try {
      std::string unpacked;
      unpack_message(target.message, unpacked);
      unpacked_ += unpacked.size();
      if (is_moving(*message.topic)) {
        for (RosTransform& one : ros_transforms(target.message)) moving_.add(std::move(one));
      } else if (is_sensor_metadata(*message.topic)) {
        sensor_times_.add(*message.topic, target.message, place.time);
      } else {
        take_message(target.message, place, topic, transforms_);
      }
    } catch (const InputError& error) {
      if (topic.damage.empty()) topic.damage = error.what();
    }
    if (unpacked_ <= budget_) return;
    throw InputError(
        fmt::format("{}: {} bytes were unpacked from its messages, expected at most {}: it is "
                    "damaged",
                    path.string(), unpacked_, budget_));
  }

  // A small file may have many messages: their topic is looked up without copies of its name.
  ScanTarget& target_of(const BagTopic& name, const fs::path& path) {
    const auto [found, fresh] = targets_.try_emplace(&name);
    ScanTarget& target = found->second;
    if (!fresh) return target;
    target.topic = &topics_[{name.name, name.type}];
    if (target.topic->messages == 0) target.topic->topic = name;
    target.message.wire = name.wire;
    target.message.where = fmt::format("{}: topic {:.100}", path.string(), name.name);
    return target;
  }

  TopicMap topics_;
  std::map<const BagTopic*, ScanTarget> targets_;  // of the file that is scanned
  StaticTransforms transforms_;
  MovingTransforms moving_;
  SensorTimes sensor_times_;
  std::vector<FileSpan> spans_;
  std::uint64_t unpacked_ = 0, budget_ = 0;  // of messages that are compressed by themselves
};

}  // namespace

bool is_of(const TopicContents& topic, const std::string& type) {
  return topic.topic.type == type && topic.topic.wire != Wire::kOther;
}

bool is_image(const TopicContents& topic) {
  return is_of(topic, "sensor_msgs/Image") || (is_of(topic, "sensor_msgs/CompressedImage") &&
                                               !topic.topic.name.ends_with("/compressedDepth"));
}

std::vector<OpenBag> open_bags(const std::vector<fs::path>& files) {
  std::vector<OpenBag> bags;
  for (const fs::path& file : files) bags.push_back({.path = file, .file = open_bag_file(file)});
  return bags;
}

BagContents scan_open_bags(const std::vector<OpenBag>& bags) {
  BagContents contents;
  BagScan scan;
  for (const OpenBag& bag : bags) scan.scan(bag, contents);
  scan.check_breaks();
  scan.move_to(contents);
  return contents;
}

BagContents scan_bags(const std::vector<fs::path>& files) {
  return scan_open_bags(open_bags(files));
}

}  // namespace chasles
