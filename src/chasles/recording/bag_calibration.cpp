#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <chasles/bags/camera_info.hpp>
#include <chasles/bags/transform_tree.hpp>
#include <chasles/base/error.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/recording/bag_calibration.hpp>

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
std::string info_name(const TopicContents& images) {
  return split_topic(raw_topic(images.topic.name)).first + "/camera_info";
}

const TopicContents* find_info(const BagContents& contents, const TopicContents& images) {
  const std::string name = info_name(images);
  for (const TopicContents& topic : contents.topics) {
    if (topic.topic.name == name && is_of(topic, "sensor_msgs/CameraInfo")) return &topic;
  }
  return nullptr;
}

const TopicContents& info_beside(const std::string& bag, const BagContents& contents,
                                 const TopicContents& images) {
  const TopicContents* found = find_info(contents, images);
  if (found != nullptr && !found->damage.empty()) throw InputError(found->damage);
  if (found != nullptr && found->info) return *found;
  throw InputError(
      fmt::format("{}: there is no sensor_msgs/CameraInfo on {}, expected the "
                  "calibration of {} there, {}",
                  bag, info_name(images), images.topic.name, kOtherwise));
}

TreeTransform extrinsics_of(const std::string& bag, const BagContents& contents,
                            const TopicContents& imu, const TopicContents& images,
                            std::vector<std::string>& remarks) {
  for (const TopicContents& topic : contents.topics) {
    if (topic.topic.name.ends_with("tf_static") && !topic.damage.empty()) {
      throw InputError(topic.damage);
    }
  }
  const auto found = transform_between(contents, images.frame, imu.frame, remarks);
  if (found) return *found;
  throw InputError(fmt::format(
      "{}: its {} static transforms (/tf_static) do not lead from '{}', the frame of {}, to '{}', "
      "the frame of {}{}; expected where the camera is against the IMU there, {}",
      bag, contents.transforms.size(), imu.frame, imu.topic.name, images.frame, images.topic.name,
      moving_advice(contents, images.frame, imu.frame, "camera"), kOtherwise));
}

Eigen::Matrix3d rectification(const RosCameraInfo& info, const std::string& where) {
  Eigen::Matrix3d R;
  for (int i = 0; i < 9; ++i) R(i / 3, i % 3) = info.R[static_cast<std::size_t>(i)];
  return R.isZero(0) ? Eigen::Matrix3d::Identity() : checked_rotation(where + ": R", R);
}

bool is_rectified(const TopicContents& images) {
  return split_topic(raw_topic(images.topic.name)).second.starts_with("image_rect");
}

// P = K [I | t]: where the camera is against the frame of its rectified images.
Eigen::Vector3d place_of(const RosCameraInfo& info) {
  return {info.P[3] / info.P[0], info.P[7] / info.P[5], 0};
}

// A depth camera's driver calls the images of its sensors image_rect_raw, whose K and D are those
// of the lens that is left: D is zero, or that of a sensor that it does not rectify.
bool is_as_its_lens_states(const TopicContents& images, const RosCameraInfo& info,
                           const std::string& where) {
  const bool named = split_topic(raw_topic(images.topic.name)).second == "image_rect_raw";
  return named && rectification(info, where).isIdentity(1e-12) && place_of(info).isZero(0);
}

// By ROS's convention the rectified images of a pair are both in the frame of the first camera:
// that camera's CameraInfo, whose R leads to the rectified frame. None where the images have a
// frame of their own.
const RosCameraInfo* owner_of_frame(const BagContents& contents, const TopicContents& images) {
  for (const TopicContents& other : contents.topics) {
    if (!is_image(other) || !is_rectified(other) || other.frame != images.frame) continue;
    const TopicContents* info = find_info(contents, other);
    if (info != nullptr && info->info && place_of(*info->info).isZero(0)) return &*info->info;
  }
  return nullptr;
}

SE3 rectified_T_frame(const BagContents& contents, const TopicContents& images,
                      const RosCameraInfo& info, const std::string& where) {
  const Eigen::Vector3d place = place_of(info);
  const RosCameraInfo* owner = place.isZero(0) ? nullptr : owner_of_frame(contents, images);
  if (owner == nullptr) return {rectification(info, where), Eigen::Vector3d::Zero()};
  return {rectification(*owner, where), place};
}

void check_places(const std::string& bag, const ChosenTopics& chosen,
                  const std::vector<Camera>& cameras) {
  for (std::size_t c = 1; c < cameras.size(); ++c) {
    const SE3 between = cameras[c].cam_T_imu * cameras[0].cam_T_imu.inverse();
    if (!between.R.isIdentity(1e-9) || !between.p.isZero(1e-9)) continue;
    throw InputError(fmt::format(
        "{}: cam0 and cam{} are at the same place, by the frames '{}' of {} and '{}' of {}, "
        "expected two cameras apart: give each its own frame in /tf_static, {}",
        bag, c, chosen.cameras[0]->frame, chosen.cameras[0]->topic.name, chosen.cameras[c]->frame,
        chosen.cameras[c]->topic.name, kOtherwise));
  }
}

}  // namespace

void calibrate_by_bag(const std::string& bag, const BagContents& contents,
                      const ChosenTopics& chosen, Recording& recording) {
  for (const TopicContents* images : chosen.cameras) {
    const TopicContents& info = info_beside(bag, contents, *images);
    const std::string where = fmt::format("{}: topic {}", bag, info.topic.name);
    const bool rectified =
        is_rectified(*images) && !is_as_its_lens_states(*images, *info.info, where);
    Camera camera = camera_of(*info.info, rectified, where);
    const TreeTransform extrinsics =
        extrinsics_of(bag, contents, *chosen.imu, *images, recording.remarks);
    camera.cam_T_imu = extrinsics.to_T_from;
    if (rectified) {
      camera.cam_T_imu = rectified_T_frame(contents, *images, *info.info, where) * camera.cam_T_imu;
    }
    recording.remarks.push_back(
        fmt::format("cam{} is {}, calibrated by {} and {} ('{}' to '{}'); no time offset is known",
                    recording.cameras.size(), images->topic.name, info.topic.name, extrinsics.topic,
                    chosen.imu->frame, images->frame));
    recording.cameras.push_back(camera);
  }
  check_places(bag, chosen, recording.cameras);
}

}  // namespace chasles
