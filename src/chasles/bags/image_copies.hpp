#pragma once

#include <optional>
#include <string>
#include <vector>

#include <chasles/bags/bag_contents.hpp>

namespace chasles {

// Topics with the same images in several forms: /camera/image_raw, /camera/image_raw/compressed and
// /camera/image_raw/ffmpeg.

/// The name of a topic of images without /compressed.
std::string raw_topic(const std::string& name);

/// The name without any of the endings of such forms.
std::string images_topic(const std::string& name);

/// Whether the messages of a type are packets of a video.
bool is_video_type(std::string_view type);

/// What a packet of such a type says of its format; empty if it says nothing that is a name.
std::string packet_format(std::string_view type, const RosMessage& message);

/// The kind of a video whose single messages are no images, by the type of the topic or by the
/// format that its first message states: "h264 video of ffmpeg_image_transport_msgs/FFMPEGPacket".
/// None of a topic of other messages.
std::optional<std::string> video_kind(const TopicContents& topic);

/// Why such a topic cannot be read, and how to convert it.
std::string video_rejection(const TopicContents& topic);

/// Whether the format of a sensor_msgs/CompressedImage, "mono8; png compressed mono8", is one that
/// is read: PNG, JPEG, PGM, BMP, TIFF or WebP.
bool is_read_format(const std::string& format);

/// Whether the topic has images that can be read one by one.
bool is_readable_image(const TopicContents& topic);

/// `preferred`, or that copy of its images that has considerably more of them: more different
/// stamps, by over 2 %. A recorder that cannot keep up, or a throttle, drops images of one form
/// only. `remarks` receives a sentence where the numbers differ.
const TopicContents* fullest_copy(const std::vector<TopicContents>& topics,
                                  const TopicContents& preferred,
                                  std::vector<std::string>& remarks);

}  // namespace chasles
