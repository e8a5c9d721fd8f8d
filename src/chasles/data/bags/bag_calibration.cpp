#include <utility>

#include <fmt/format.h>

#include <chasles/data/bags/bag_calibration.hpp>
#include <chasles/data/bags/camera_info.hpp>
#include <chasles/data/numbers.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

// The last part of a topic's name and what is before it.
std::pair<std::string, std::string> split_topic(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  if (slash == std::string::npos) return {"", name};
  return {name.substr(0, slash), name.substr(slash + 1)};
}

const char* const kOtherwise =
    "or Kalibr's files beside the bag (camchain-imucam.yaml and imu.yaml)";

// image_transport has it beside the raw topic.
const TopicContents& info_beside(const std::string& bag, const BagContents& contents,
                                 const TopicContents& images) {
  const std::string name = split_topic(raw_topic(images.topic.name)).first + "/camera_info";
  for (const TopicContents& topic : contents.topics) {
    if (topic.topic.name != name || !is_of(topic, "sensor_msgs/CameraInfo")) continue;
    if (!topic.damage.empty()) throw InputError(topic.damage);
    if (topic.info) return topic;
  }
  throw InputError(
      fmt::format("{}: there is no sensor_msgs/CameraInfo on {}, expected the "
                  "calibration of {} there, {}",
                  bag, name, images.topic.name, kOtherwise));
}

SE3 extrinsics_of(const std::string& bag, const BagContents& contents, const TopicContents& imu,
                  const TopicContents& images) {
  for (const TopicContents& topic : contents.topics) {
    if (topic.topic.name.ends_with("tf_static") && !topic.damage.empty()) {
      throw InputError(topic.damage);
    }
  }
  const auto found = find_transform(contents.transforms, images.frame, imu.frame);
  if (found && !imu.frame.empty() && !images.frame.empty()) return *found;
  throw InputError(fmt::format(
      "{}: its {} static transforms (/tf_static) do not lead from '{}', the frame of {}, to '{}', "
      "the frame of {}, expected where the camera is against the IMU there, {}",
      bag, contents.transforms.size(), imu.frame, imu.topic.name, images.frame, images.topic.name,
      kOtherwise));
}

Eigen::Matrix3d rectification(const RosCameraInfo& info, const std::string& where) {
  Eigen::Matrix3d R;
  for (int i = 0; i < 9; ++i) R(i / 3, i % 3) = info.R[static_cast<std::size_t>(i)];
  return R.isZero(0) ? Eigen::Matrix3d::Identity() : checked_rotation(where + ": R", R);
}

}  // namespace

void calibrate_by_bag(const std::string& bag, const BagContents& contents,
                      const ChosenTopics& chosen, Recording& recording) {
  for (const TopicContents* images : chosen.cameras) {
    const TopicContents& info = info_beside(bag, contents, *images);
    const std::string where = fmt::format("{}: topic {}", bag, info.topic.name);
    const bool rectified =
        split_topic(raw_topic(images->topic.name)).second.starts_with("image_rect");
    Camera camera = camera_of(*info.info, rectified, where);
    camera.cam_T_imu = extrinsics_of(bag, contents, *chosen.imu, *images);
    if (rectified) {
      camera.cam_T_imu =
          SE3{rectification(*info.info, where), Eigen::Vector3d::Zero()} * camera.cam_T_imu;
    }
    recording.remarks.push_back(
        fmt::format("cam{} is {}, calibrated by {} and /tf_static ('{}' to '{}'); no time offset "
                    "is known",
                    recording.cameras.size(), images->topic.name, info.topic.name,
                    chosen.imu->frame, images->frame));
    recording.cameras.push_back(camera);
  }
}

}  // namespace chasles
