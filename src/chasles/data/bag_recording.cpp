#include <chasles/data/readers.hpp>
#include <chasles/error.hpp>

#ifndef CHASLES_HAS_ROSBAG

namespace chasles {

Recording read_bag_recording(const std::filesystem::path& file) {
  throw InputError(file.string() +
                   ": is a ROS bag, and this program was built without librosbag-storage: install "
                   "Debian's or Ubuntu's librosbag-storage-dev and build it again");
}

}  // namespace chasles

#else

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <chasles/data/bag_structure.hpp>
#include <chasles/data/bag_topics.hpp>
#include <chasles/data/image_recording.hpp>
#include <chasles/data/pair_images.hpp>
#include <chasles/data/ros_message.hpp>
#include <chasles/data/time_order.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// Converts every exception of the library on a damaged bag to an InputError with the file's name.
template <typename Call>
auto guarded(const fs::path& file, Call&& call) {
  try {
    return call();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw InputError(fmt::format("{}: the bag cannot be read: {} (rosbag reindex may repair it)",
                                 file.string(), error.what()));
  }
}

std::string bytes_of(const rosbag::MessageInstance& message) {
  std::string bytes(message.size(), '\0');
  ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()),
                                     static_cast<std::uint32_t>(bytes.size()));
  message.write(stream);
  return bytes;
}

std::vector<BagTopic> topics_of(const rosbag::Bag& bag) {
  std::map<std::string, std::string> types;
  rosbag::View view(bag);
  for (const rosbag::ConnectionInfo* info : view.getConnections()) {
    types[info->topic] = info->datatype;
  }
  std::vector<BagTopic> topics;
  for (const auto& [name, type] : types) topics.push_back({name, type});
  return topics;
}

// An image's own stamp, and its place in the bag.
struct BagImage {
  Time time{};
  ros::Time recorded;
};

/// The images of a bag; each is found by its recording time.
class BagImages : public ImageSource {
 public:
  BagImages(const fs::path& file, std::vector<std::string> topics, std::vector<ImageSize> sizes)
      : file_(file), topics_(std::move(topics)), sizes_(std::move(sizes)), images_(topics_.size()) {
    bag_.open(file.string(), rosbag::bagmode::Read);
  }
  // Finds all images by their stamps.
  void index(std::vector<std::string>& remarks) {
    std::vector<std::vector<Time> > stamps(topics_.size());
    for (std::size_t c = 0; c < topics_.size(); ++c) {
      rosbag::View view(bag_, rosbag::TopicQuery(topics_[c]));
      for (const rosbag::MessageInstance& message : view) {
        images_[c].push_back(
            {.time = ros_stamp(bytes_of(message), where(c)), .recorded = message.getTime()});
      }
      bring_into_order(images_[c], fmt::format("images of cam{}", c), remarks);
      for (const BagImage& image : images_[c]) stamps[c].push_back(image.time);
    }
    frames_ = pair_images(stamps, kSameInstant, remarks);
  }
  std::size_t size() const override { return frames_.size(); }
  Time time(std::size_t i) const override { return frames_[i].time; }
  ImageFrame read(std::size_t i) const override {
    ImageFrame frame{.time = frames_[i].time, .images = {}};
    for (std::size_t c = 0; c < topics_.size(); ++c) {
      const auto& member = frames_[i].members[c];
      frame.images.push_back(member ? read(c, images_[c][*member]) : GrayImage{});
    }
    return frame;
  }

 private:
  std::string where(std::size_t camera) const {
    return fmt::format("{}: topic {}", file_.string(), topics_[camera]);
  }
  GrayImage read(std::size_t camera, const BagImage& image) const {
    const std::string place = fmt::format("{} at {} ns", where(camera), image.time.count());
    return guarded(file_, [&] {
      rosbag::View view(bag_, rosbag::TopicQuery(topics_[camera]), image.recorded, image.recorded);
      for (const rosbag::MessageInstance& message : view) {
        const std::string bytes = bytes_of(message);
        if (ros_stamp(bytes, place) != image.time) continue;
        return message.getDataType() == "sensor_msgs/Image"
                   ? ros_image(bytes, sizes_[camera], place)
                   : ros_compressed_image(bytes, sizes_[camera], place);
      }
      throw InputError(place + ": the image is no longer there: was the bag changed?");
    });
  }

  fs::path file_;
  rosbag::Bag bag_;
  std::vector<std::string> topics_;
  std::vector<ImageSize> sizes_;
  std::vector<std::vector<BagImage> > images_;
  std::vector<PairedFrame> frames_;
};

void check_type(const fs::path& file, const std::vector<BagTopic>& topics, const std::string& name,
                const std::vector<std::string>& types) {
  for (const BagTopic& topic : topics) {
    if (topic.name != name) continue;
    if (std::find(types.begin(), types.end(), topic.type) != types.end()) return;
    throw InputError(fmt::format("{}: topic {} is of {}, expected {}", file.string(), name,
                                 topic.type, fmt::join(types, " or ")));
  }
}

KalibrCalibration calibration_beside(const fs::path& file) {
  const auto files = find_kalibr(file.has_parent_path() ? file.parent_path() : fs::path("."));
  if (files) return read_kalibr(*files);
  throw InputError(
      fmt::format("{}: there is no camchain-imucam.yaml beside it, expected Kalibr's "
                  "calibration of the cameras and imu.yaml there",
                  file.string()));
}

Recording read_bag(const fs::path& file) {
  const KalibrCalibration calibration = calibration_beside(file);
  check_bag_structure(file);
  rosbag::Bag bag;  // opened later, because a constructor that throws leaks memory
  bag.open(file.string(), rosbag::bagmode::Read);
  const std::vector<BagTopic> topics = topics_of(bag);
  const ChosenTopics chosen = choose_topics(file, topics, calibration);
  check_type(file, topics, chosen.imu, {"sensor_msgs/Imu"});
  Recording recording;
  recording.name = file.stem().string();
  recording.cameras = calibration.cameras;
  recording.imu_noise = calibration.imu_noise;
  recording.imu_range = calibration.imu_range;
  recording.remarks = calibration.remarks;
  std::vector<ImageSize> sizes;
  for (std::size_t c = 0; c < chosen.cameras.size(); ++c) {
    check_type(file, topics, chosen.cameras[c],
               {"sensor_msgs/Image", "sensor_msgs/CompressedImage"});
    sizes.push_back({recording.cameras[c].width, recording.cameras[c].height});
  }
  rosbag::View samples(bag, rosbag::TopicQuery(chosen.imu));
  for (const rosbag::MessageInstance& message : samples) {
    recording.imu.push_back(ros_imu(bytes_of(message), file.string() + ": topic " + chosen.imu));
  }
  tidy_samples(file, recording);
  const auto images = std::make_shared<BagImages>(file, chosen.cameras, std::move(sizes));
  images->index(recording.remarks);
  recording.images = images;
  remark_on_coverage(recording);
  return recording;
}

}  // namespace

Recording read_bag_recording(const fs::path& file) {
  return guarded(file, [&] { return read_bag(file); });
}

}  // namespace chasles

#endif
