#include "topic_calibration.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <chasles/bags/bag_imu.hpp>
#include <chasles/bags/bag_topics.hpp>
#include <chasles/base/error.hpp>
#include <chasles/recording/bag_calibration.hpp>

namespace chasles::ros1 {
namespace {

TopicContents topic_of(const std::string& name, const std::string& type) {
  TopicContents contents;
  contents.topic = {.name = name, .type = type};
  return contents;
}

// image_transport has it beside the raw topic.
std::string info_topic_of(const std::string& images) {
  const std::string raw = raw_topic(images);
  return raw.substr(0, raw.rfind('/') + 1) + "camera_info";
}

void set_frame(const std::string& frame, TopicContents& topic) {
  if (topic.frame.empty()) topic.frame = frame;
}

}  // namespace

TopicCalibration::TopicCalibration(SensorCalibration imu, const std::string& imu_topic,
                                   const std::vector<std::string>& camera_topics,
                                   const std::string& accelerometer_topic)
    : imu_(std::move(imu)),
      cameras_(camera_topics.size()),
      accelerometer_(topic_of(accelerometer_topic, "sensor_msgs/Imu")) {
  contents_.topics.push_back(topic_of(imu_topic, "sensor_msgs/Imu"));
  for (const std::string& images : camera_topics) {
    contents_.topics.push_back(topic_of(images, "sensor_msgs/Image"));
    contents_.topics.push_back(topic_of(info_topic_of(images), "sensor_msgs/CameraInfo"));
  }
}

std::vector<std::string> TopicCalibration::info_topics() const {
  std::vector<std::string> topics;
  for (std::size_t c = 0; c < cameras_; ++c) {
    topics.push_back(contents_.topics[2 * c + 2].topic.name);
  }
  return topics;
}

void TopicCalibration::set_imu_frame(const std::string& frame) {
  set_frame(frame, contents_.topics[0]);
}

void TopicCalibration::set_image_frame(std::size_t camera, const std::string& frame) {
  set_frame(frame, images(camera));
}

void TopicCalibration::set_info(std::size_t camera, const RosCameraInfo& of_camera) {
  if (!info(camera).info) info(camera).info = of_camera;
}

void TopicCalibration::set_accelerometer_frame(const std::string& frame) {
  set_frame(frame, accelerometer_);
}

void TopicCalibration::add_transforms(const std::vector<RosTransform>& transforms) {
  add_static_transforms(transforms, contents_.transforms);
}

void add_static_transforms(const std::vector<RosTransform>& transforms,
                           std::vector<RosTransform>& known) {
  for (const RosTransform& transform : transforms) {
    const auto found = std::ranges::find(known, transform.child, &RosTransform::child);
    if (found == known.end()) {
      known.push_back(transform);
    } else {
      *found = transform;
    }
  }
}

std::optional<SensorCalibration> TopicCalibration::calibration() {
  ChosenTopics chosen;
  chosen.imu = &contents_.topics[0];
  for (std::size_t c = 0; c < cameras_; ++c) {
    if (images(c).frame.empty() || chosen.imu->frame.empty()) {
      missing_ =
          fmt::format("no message with a frame_id has come on {}",
                      images(c).frame.empty() ? images(c).topic.name : chosen.imu->topic.name);
      return std::nullopt;
    }
    chosen.cameras.push_back(&images(c));
    chosen.chain.push_back(c);
  }
  if (!accelerometer_.topic.name.empty() && accelerometer_.frame.empty()) {
    missing_ = fmt::format("no message with a frame_id has come on {}", accelerometer_.topic.name);
    return std::nullopt;
  }
  Recording recording;
  try {
    calibrate_by_bag("the topics", contents_, chosen, recording);
  } catch (const InputError& error) {
    missing_ = error.what();
    return std::nullopt;
  }
  SensorCalibration result = imu_;
  result.cameras = recording.cameras;
  result.time_offsets.assign(cameras_, Time::zero());
  result.remarks.insert(result.remarks.end(), recording.remarks.begin(), recording.remarks.end());
  if (!accelerometer_.topic.name.empty()) take_split(result);
  missing_.clear();
  return result;
}

// As the reader of bags: the IMU has the axes of the gyroscope and the place of the accelerometer.
void TopicCalibration::take_split(SensorCalibration& result) const {
  const SplitExtrinsics extrinsics =
      split_extrinsics(accelerometer_, contents_.topics[0], contents_);
  result.gyro_R_accel = extrinsics.gyro_T_accel.R;
  const SE3 moved{Eigen::Matrix3d::Identity(), extrinsics.gyro_T_accel.p};
  for (Camera& camera : result.cameras) camera.cam_T_imu = camera.cam_T_imu * moved;
  result.remarks.insert(result.remarks.end(), extrinsics.remarks.begin(), extrinsics.remarks.end());
}

}  // namespace chasles::ros1
