#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <chasles/bags/image_copies.hpp>
#include <chasles/bags/ros_image.hpp>
#include <chasles/base/error.hpp>
#include <chasles/camera/rig_overlap.hpp>
#include <chasles/codec/image_range.hpp>
#include <chasles/recording/bag_images.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/paired_images.hpp>
#include <chasles/recording/time_order.hpp>

namespace chasles {
namespace {

/// The images of one camera.
struct CameraImages {
  std::string where;  // the bag and the topic
  BagTopic topic;
  ImageSize size;
  int bits = kAllBits;  // of the 16, those in use
  std::vector<BagImage> images;
};

using BagFiles = std::vector<std::shared_ptr<const BagFile>>;

// Reads the message of an image. Calls `raw` with a sensor_msgs/Image, or `packed` with the bytes
// of a PNG or a JPEG; both with the name for messages.
template <typename Raw, typename Packed>
auto visit_image(const BagFiles& files, const CameraImages& camera, const BagImage& image,
                 const Raw& raw, const Packed& packed) {
  RosMessage message{.bytes = {}, .wire = camera.topic.wire};
  message.where = fmt::format("{} at {} ns", camera.where, image.time.count());
  const std::string bytes = files[image.file]->read(image.place);
  std::string unpacked;
  message.bytes = bytes;
  unpack_message(message, unpacked);
  return camera.topic.type == "sensor_msgs/Image"
             ? raw(ros_image(message), message.where)
             : packed(ros_compressed_image(message), message.where);
}

class BagImages : public PairedImages {
 public:
  BagImages(BagFiles files, std::vector<CameraImages> cameras, std::vector<PairedFrame> frames)
      : PairedImages(std::move(frames), cameras.size()),
        files_(std::move(files)),
        cameras_(std::move(cameras)) {}

 private:
  GrayImage read_one(std::size_t index, std::size_t image) const override {
    const CameraImages& camera = cameras_[index];
    return visit_image(
        files_, camera, camera.images[image],
        [&](const RosImage& raw, const std::string& where) {
          return grey_image(raw, camera.size, camera.bits, where);
        },
        [&](std::string_view packed, const std::string& where) {
          return decode_image(packed, camera.size, where, camera.bits);
        });
  }

  BagFiles files_;
  std::vector<CameraImages> cameras_;
};

// Images of a kind that is not read, as their messages say; one that is damaged is no such case.
void check_format(const TopicContents& topic, const std::string& where) {
  if (topic.width > 0 || topic.format.empty() || is_read_format(topic.format)) return;
  throw InputError(fmt::format(
      "{}: its images have the format '{}', expected one of {}, or raw images: play the bag, "
      "convert with `ros2 run image_transport republish compressed raw --ros-args -r "
      "in/compressed:={} -r out:={}`, and record that",
      where, topic.format, kImageKindNames, topic.topic.name, raw_topic(topic.topic.name)));
}

void check_first(const TopicContents& topic, const Camera& camera, const std::string& where) {
  const bool raw = topic.topic.type == "sensor_msgs/Image" && topic.width > 0;
  if (raw || !topic.encoding.empty()) check_encoding(topic.encoding, where);
  check_format(topic, where);
  if (topic.width == 0 || (topic.width == camera.width && topic.height == camera.height)) return;
  throw ImageSizeError(
      fmt::format("{}: its images have {} x {} pixels, expected {} x {} as in the "
                  "calibration",
                  where, topic.width, topic.height, camera.width, camera.height));
}

std::optional<int> largest_value(const BagFiles& files, const CameraImages& camera,
                                 const BagImage& image) {
  const auto largest = [&](const auto& pixels, const std::string& where) {
    return largest_deep_value(pixels, camera.size, where);
  };
  return visit_image(files, camera, image, largest, largest);
}

CameraImages camera_images(const BagFiles& files, const TopicContents& topic, const Camera& camera,
                           std::size_t number, const std::string& bag,
                           std::vector<std::string>& remarks) {
  CameraImages images{.where = fmt::format("{}: topic {:.100}", bag, topic.topic.name),
                      .topic = topic.topic,
                      .size = {.width = camera.width, .height = camera.height},
                      .images = topic.images};
  check_first(topic, camera, images.where);
  bring_into_order(images.images, fmt::format("images of cam{}", number), remarks);
  const auto range = deep_range(images.images.size(), [&](std::size_t i) {
    return largest_value(files, images, images.images[i]);
  });
  if (!range) return images;
  images.bits = range->bits;
  remarks.push_back(deep_remark(*range, fmt::format("cam{}", number)));
  return images;
}

}  // namespace

std::shared_ptr<const ImageSource> open_bag_images(
    const BagFiles& files, std::vector<const TopicContents*> topics, const std::vector<Camera>& rig,
    const std::vector<Time>& offsets, const std::string& where, std::vector<std::string>& remarks) {
  std::vector<CameraImages> cameras;
  std::vector<std::vector<Time>> stamps(topics.size());
  for (std::size_t c = 0; c < topics.size(); ++c) {
    cameras.push_back(camera_images(files, *topics[c], rig[c], c, where, remarks));
    const Time offset = offsets.empty() ? Time::zero() : offsets[c];
    for (const BagImage& image : cameras[c].images) {
      stamps[c].push_back(by_imu_clock(image.time, offset, cameras[c].where));
    }
  }
  std::vector<PairedFrame> frames = pair_images(stamps, are_finders(rig), kSameInstant, remarks);
  return std::make_shared<BagImages>(files, std::move(cameras), std::move(frames));
}

}  // namespace chasles
