#pragma once

#include <string>

#include <chasles/bags/bag_contents.hpp>
#include <chasles/bags/bag_topics.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// Calibrates the cameras of the chosen topics by the bag itself: the sensor_msgs/CameraInfo beside
/// each topic of images, and the static transforms (/tf_static) from the frame of the IMU's
/// messages to that of the images; where they lack one, those of /tf that are constant. Images of a
/// topic image_rect… are rectified: P and R of the CameraInfo apply. If such a pair has one frame,
/// the fourth column of P places the second camera (REP 104, sensor_msgs/CameraInfo). Throws
/// InputError that says what is missing, and for two cameras at the same place.
void calibrate_by_bag(const std::string& bag, const BagContents& contents,
                      const ChosenTopics& chosen, Recording& recording);

}  // namespace chasles
