#pragma once

#include <string>
#include <vector>

#include <chasles/bags/bag_contents.hpp>
#include <chasles/bags/ros_messages.hpp>
#include <chasles/recording/sensor_calibration.hpp>

namespace chasles::ros1 {

/// Calibrates cameras by what a bag without a calibration file has (docs/formats.md): the
/// CameraInfo beside each topic of images, and the static transforms from the frame of the IMU's
/// messages to that of the images.
class TopicCalibration {
 public:
  /// `imu`: the calibration of the IMU alone. `accelerometer_topic`: of its own; then `imu_topic`
  /// is the gyroscope's.
  TopicCalibration(SensorCalibration imu, const std::string& imu_topic,
                   const std::vector<std::string>& camera_topics,
                   const std::string& accelerometer_topic = {});

  /// The topics of the CameraInfo, one for each camera.
  std::vector<std::string> info_topics() const;

  // What messages state. Frames and infos: the first one counts; of a frame's transforms the last.
  void set_imu_frame(const std::string& frame);
  void set_accelerometer_frame(const std::string& frame);
  void set_image_frame(std::size_t camera, const std::string& frame);
  void set_info(std::size_t camera, const RosCameraInfo& info);
  void add_transforms(const std::vector<RosTransform>& transforms);

  /// The calibration, once all of it has come. Until then missing() has a sentence on what is not
  /// there.
  std::optional<SensorCalibration> calibration();
  const std::string& missing() const { return missing_; }

 private:
  TopicContents& images(std::size_t camera) { return contents_.topics[2 * camera + 1]; }
  TopicContents& info(std::size_t camera) { return contents_.topics[2 * camera + 2]; }

  void take_split(SensorCalibration& result) const;

  SensorCalibration imu_;
  std::size_t cameras_;
  BagContents contents_;         ///< topics: the IMU, then images and CameraInfo of each camera
  TopicContents accelerometer_;  ///< without a name: none
  std::string missing_;
};

/// Adds transforms to those that are known: of a frame the last one counts.
void add_static_transforms(const std::vector<RosTransform>& transforms,
                           std::vector<RosTransform>& known);

}  // namespace chasles::ros1
