#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/bags/bag_file.hpp>
#include <chasles/bags/bag_paths.hpp>
#include <chasles/bags/ros_messages.hpp>
#include <chasles/base/error.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/recording/time_order.hpp>
#include <chasles/recording/truth_table.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLeastStampedTransform = 60;  // bytes of a geometry_msgs/TransformStamped

enum class PoseType { kPose, kOdometry, kTransform, kTransforms, kPoint };

struct NamedPoseType {
  std::string_view name;
  PoseType type;
};
constexpr std::array kPoseTypes{
    NamedPoseType{"geometry_msgs/PoseStamped", PoseType::kPose},
    NamedPoseType{"geometry_msgs/PoseWithCovarianceStamped", PoseType::kPose},
    NamedPoseType{"nav_msgs/Odometry", PoseType::kOdometry},
    NamedPoseType{"geometry_msgs/TransformStamped", PoseType::kTransform},
    NamedPoseType{"geometry_msgs/PointStamped", PoseType::kPoint},
    NamedPoseType{"tf2_msgs/TFMessage", PoseType::kTransforms},
    NamedPoseType{"tf/tfMessage", PoseType::kTransforms}};

std::optional<PoseType> pose_type(const BagTopic& topic) {
  if (topic.wire == Wire::kOther) return std::nullopt;
  const auto found = std::ranges::find(kPoseTypes, topic.type, &NamedPoseType::name);
  return found == kPoseTypes.end() ? std::nullopt : std::optional(found->type);
}

// The poses of one topic, or of one pair of frames of a TFMessage.
struct PoseStream {
  std::string topic, type, frame, child;
  Trajectory poses;
  std::size_t messages = 0, unset = 0, lost = 0;  // without a stamp; without a pose
  bool attitudes = true;

  bool is_tf() const { return type.ends_with("essage"); }
  std::string text() const {
    const std::string child_of = child.empty() ? "" : fmt::format(", {} in {}", child, frame);
    return fmt::format("{}{} ({}{}: {} poses)", topic, is_tf() ? ":" + child : std::string(), type,
                       child_of, poses.size());
  }
};

using Streams = std::map<std::tuple<std::string, std::string, std::string>, PoseStream>;

std::string plain_frame(std::string_view text) {
  if (text.starts_with('/')) text.remove_prefix(1);
  return std::string(text);
}

class PoseScan {
 public:
  void take(const BagMessage& message, const std::string& where) {
    const auto type = pose_type(*message.topic);
    if (!type) return;
    std::string unpacked;
    RosMessage ros{.bytes = message.bytes, .wire = message.topic->wire, .where = where};
    unpack_message(ros, unpacked);
    MessageFields fields(ros.bytes, ros.wire, ros.where);
    const bool list = *type == PoseType::kTransforms;
    const std::size_t count = list ? fields.count(kLeastStampedTransform) : 1;
    for (std::size_t i = 0; i < count; ++i) take_one(fields, *type, *message.topic, where);
  }
  Streams streams;

 private:
  void take_one(MessageFields& fields, PoseType type, const BagTopic& topic,
                const std::string& where) {
    const MessageHeader header = fields.header();
    const bool has_child = type != PoseType::kPose && type != PoseType::kPoint;
    const std::string frame = plain_frame(header.frame);
    const std::string child = has_child ? plain_frame(fields.text()) : std::string();
    const bool tf = type == PoseType::kTransforms;
    PoseStream& stream = streams[{topic.name, tf ? frame : "", tf ? child : ""}];
    if (stream.messages++ == 0) {
      stream.topic = topic.name;
      stream.type = topic.type;
      stream.frame = frame;
      stream.child = child;
      stream.attitudes = type != PoseType::kPoint;
    }
    SE3 pose;
    pose.p = fields.vector();
    Eigen::Vector4d xyzw(0, 0, 0, 1);
    if (stream.attitudes) {
      xyzw.head<3>() = fields.vector();
      xyzw.w() = fields.number<double>();
    }
    if (header.stamp == Time{}) {
      ++stream.unset;
    } else if (!pose.p.allFinite() || !xyzw.allFinite() || xyzw.isZero()) {
      ++stream.lost;
    } else {
      pose.R = checked_quaternion(where, xyzw);
      stream.poses.push_back({header.stamp, pose});
    }
  }
};

Streams scan_poses(const BagPaths& paths, std::vector<std::string>& remarks,
                   std::vector<std::string>& topics) {
  PoseScan scan;
  for (const fs::path& path : paths.files) {
    std::map<const BagTopic*, std::string> places;  // of the topics of this file
    open_bag_file(path)->scan(
        [&](const BagMessage& message) {
          const BagTopic& topic = *message.topic;
          std::string& where = places[&topic];
          if (where.empty()) {
            where = fmt::format("{}: topic {:.100}", path.string(), topic.name);
            topics.push_back(fmt::format("{} ({})", topic.name, topic.type));
          }
          scan.take(message, where);
        },
        remarks);
  }
  std::ranges::sort(topics);
  topics.erase(std::unique(topics.begin(), topics.end()), topics.end());
  return std::move(scan.streams);
}

bool is_asked_for(const PoseStream& stream, const std::string& topic) {
  if (topic.empty()) return true;
  for (const std::string& name : {stream.topic, plain_frame(stream.topic)}) {
    if (topic == name || (stream.is_tf() && topic == name + ":" + stream.child)) return true;
  }
  return false;
}

std::string texts(const std::vector<const PoseStream*>& streams) {
  std::vector<std::string> list;
  for (const PoseStream* stream : streams) list.push_back(stream->text());
  return fmt::format("{}", fmt::join(list, ", "));
}

const PoseStream& choose_stream(const std::string& bag, const Streams& streams,
                                const std::string& topic, const std::vector<std::string>& topics) {
  std::vector<const PoseStream*> all, asked, plain;
  for (const auto& [key, stream] : streams) {
    if (stream.poses.empty()) continue;
    all.push_back(&stream);
    if (!is_asked_for(stream, topic)) continue;
    asked.push_back(&stream);
    if (!stream.is_tf()) plain.push_back(&stream);
  }
  if (all.empty()) {
    throw InputError(fmt::format(
        "{}: has no poses to be a truth, expected a topic of PoseStamped, "
        "PoseWithCovarianceStamped, Odometry, TransformStamped, TFMessage or PointStamped with "
        "header stamps; it has {}",
        bag, topics.empty() ? "no topic" : fmt::format("{}", fmt::join(topics, ", "))));
  }
  if (asked.empty()) {
    throw InputError(
        fmt::format("{}: found no poses of '{}', expected one of {}", bag, topic, texts(all)));
  }
  if (plain.size() == 1) return *plain.front();
  if (asked.size() == 1) return *asked.front();
  throw InputError(
      fmt::format("{}: has several topics of poses, expected the name of one behind a "
                  "colon ({}:TOPIC): {}",
                  bag, fs::path(bag).filename().string(), texts(asked)));
}

}  // namespace

bool is_bag(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return is_bag_folder(path);
  if (!fs::is_regular_file(path, ignored)) return false;
  std::ifstream stream(path, std::ios::binary);
  std::array<char, 16> begin{};
  stream.read(begin.data(), begin.size());
  return begins_bag({begin.data(), static_cast<std::size_t>(stream.gcount())});
}

TruthTable read_bag_truth(const fs::path& bag, const std::string& topic,
                          std::vector<std::string>& remarks) {
  const BagPaths paths = find_bag_files(bag);
  remarks.insert(remarks.end(), paths.remarks.begin(), paths.remarks.end());
  std::vector<std::string> topics;
  const Streams streams = scan_poses(paths, remarks, topics);
  const PoseStream& stream = choose_stream(bag.string(), streams, topic, topics);
  TruthTable table{.poses = stream.poses, .attitudes = stream.attitudes};
  remarks.push_back(
      fmt::format("the truth is that of {} of {}", stream.text(), bag.filename().string()));
  if (stream.unset > 0) {
    remarks.push_back(fmt::format("{} of {} messages of {} have no header stamp: left out",
                                  stream.unset, stream.messages, stream.topic));
  }
  if (stream.lost > 0) {
    remarks.push_back(
        fmt::format("{} of {} messages of {} have no pose (NaN, or a quaternion of "
                    "zeros): left out",
                    stream.lost, stream.messages, stream.topic));
  }
  bring_into_order(table.poses, "poses of " + stream.topic, remarks);
  return table;
}

}  // namespace chasles
