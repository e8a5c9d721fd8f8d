#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

#include <chasles/bags/image_copies.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

constexpr std::string_view kCompressed = "/compressed";

constexpr std::array<std::string_view, 3> kVideoTypes{"ffmpeg_image_transport_msgs/FFMPEGPacket",
                                                      "foxglove_msgs/CompressedVideo",
                                                      "foxglove.CompressedVideo"};
constexpr std::array<std::string_view, 9> kVideoFormats{"h264", "h.264", "avc", "h265", "h.265",
                                                        "hevc", "av1",   "vp8", "vp9"};

// "h264", and "h264; yuv420p" or "hevc_nvenc" as encoders call themselves.
std::string_view video_format(const std::string& format) {
  const std::string small = lower_case(format);
  const auto known = std::ranges::find_if(
      kVideoFormats, [&](std::string_view name) { return small.starts_with(name); });
  return known == kVideoFormats.end() ? std::string_view() : *known;
}

std::size_t different_stamps(const TopicContents& topic) {
  std::vector<Time> times;
  for (const BagImage& image : topic.images) times.push_back(image.time);
  std::ranges::sort(times);
  return static_cast<std::size_t>(std::unique(times.begin(), times.end()) - times.begin());
}

}  // namespace

std::string raw_topic(const std::string& name) {
  return name.ends_with(kCompressed) ? name.substr(0, name.size() - kCompressed.size()) : name;
}

std::string images_topic(const std::string& name) {
  const std::string raw = raw_topic(name);
  for (const std::string_view ending : {"/ffmpeg", "/foxglove", "/h264", "/h265", "/video"}) {
    if (raw.ends_with(ending)) return raw.substr(0, raw.size() - ending.size());
  }
  return raw;
}

bool is_video_type(std::string_view type) {
  return std::ranges::find(kVideoTypes, type) != kVideoTypes.end();
}

// FFMPEGPacket: header, width, height, encoding, …; CompressedVideo: timestamp, frame_id, data,
// format.
std::string packet_format(std::string_view type, const RosMessage& message) {
  constexpr std::size_t kLongestName = 40;
  MessageFields fields(message.bytes, message.wire, message.where);
  std::string_view format;
  if (type.starts_with("ffmpeg")) {
    fields.header();
    fields.skip<std::uint32_t>(2);
    format = fields.text();
  } else {
    fields.skip<std::uint32_t>(2);
    fields.text();
    fields.bytes();
    format = fields.text();
  }
  const auto printable = [](unsigned char c) { return std::isprint(c) != 0; };
  const bool name = format.size() <= kLongestName && std::ranges::all_of(format, printable);
  return name ? std::string(format) : std::string();
}

std::optional<std::string> video_kind(const TopicContents& topic) {
  const std::string& type = topic.topic.type;
  if (type == "sensor_msgs/CompressedImage") {
    const std::string_view format = video_format(topic.format);
    if (format.empty()) return std::nullopt;
    return fmt::format("{} video (sensor_msgs/CompressedImage with the format '{}')", format,
                       topic.format);
  }
  if (!is_video_type(type)) return std::nullopt;
  return topic.format.empty() ? fmt::format("video ({})", type)
                              : fmt::format("{} video ({})", topic.format, type);
}

std::string video_rejection(const TopicContents& topic) {
  const std::string& name = topic.topic.name;
  const std::string images = images_topic(name), transport = topic.topic.type.substr(0, 6);
  std::string how;
  if (transport == "ffmpeg" || transport == "foxglo") {
    how = fmt::format(
        "play the bag, convert with `ros2 run image_transport republish {0} raw --ros-args -r "
        "in/{0}:={1} -r out:={2}`, and record {2}",
        transport == "ffmpeg" ? "ffmpeg" : "foxglove", name, images);
  } else {
    how =
        "write the data of its messages one after the other into cam0.h264, and decode it with "
        "`ffmpeg -i cam0.h264 -fps_mode passthrough -start_number 0 images/cam0/%06d.png`; the "
        "stamps go into images/cam0/times.csv (docs/formats.md)";
  }
  return fmt::format(
      "{} is {}, whose messages are no images one by one, expected raw images, PNG "
      "or JPEG: {}",
      name, video_kind(topic).value_or("no video"), how);
}

bool is_read_format(const std::string& format) {
  const std::string small = lower_case(format);
  return std::ranges::any_of(
      std::array<std::string_view, 8>{"png", "jpeg", "jpg", "pgm", "bmp", "tif", "pnm", "webp"},
      [&](std::string_view kind) { return small.find(kind) != std::string::npos; });
}

bool is_readable_image(const TopicContents& topic) { return is_image(topic) && !video_kind(topic); }

const TopicContents* fullest_copy(const std::vector<TopicContents>& topics,
                                  const TopicContents& preferred,
                                  std::vector<std::string>& remarks) {
  const TopicContents* fullest = &preferred;
  const std::size_t have = different_stamps(preferred);
  std::size_t most = have;
  for (const TopicContents& topic : topics) {
    const bool copy =
        raw_topic(topic.topic.name) == raw_topic(preferred.topic.name) && is_readable_image(topic);
    const std::size_t stamps = copy ? different_stamps(topic) : 0;
    if (stamps <= most) continue;
    most = stamps;
    fullest = &topic;
  }
  if (fullest == &preferred) return fullest;
  const bool considerable = 50 * (most - have) > most;
  remarks.push_back(
      fmt::format("{} has images at {} times, its copy {} at {}: the images of {} are taken",
                  preferred.topic.name, have, fullest->topic.name, most,
                  (considerable ? fullest : &preferred)->topic.name));
  return considerable ? fullest : &preferred;
}

}  // namespace chasles
