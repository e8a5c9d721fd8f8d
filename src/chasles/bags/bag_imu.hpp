#pragma once

#include <string>
#include <vector>

#include <chasles/bags/bag_contents.hpp>

namespace chasles {

/// What a topic of sensor_msgs/Imu measures.
enum class ImuParts { kBoth, kForces, kRates };

/// By the samples: a part of which all values are zero or not finite is not measured. kBoth where
/// neither is.
ImuParts measured_parts(const TopicContents& topic);
/// The same; where both are measured, by the covariances of the messages: of a part that is not
/// measured the first element is -1 (sensor_msgs/Imu).
ImuParts stated_parts(const TopicContents& topic);

/// "accelerations and angular rates", "accelerations alone" or "angular rates alone".
std::string parts_text(ImuParts parts);

/// Of these topics the one whose name goes with `topic`: the only one, or the only one whose name
/// differs only in "accel" for "gyro" and the like. Null without one.
const TopicContents* partner_of(const TopicContents& topic,
                                const std::vector<const TopicContents*>& others);

/// Where the accelerometer is against the gyroscope.
struct SplitExtrinsics {
  SE3 gyro_T_accel = {};
  std::vector<std::string> remarks = {};
};
/// By the transforms between the frames of the two topics (transform_between()); the identity, with
/// a remark, where there are none.
SplitExtrinsics split_extrinsics(const TopicContents& accelerometer, const TopicContents& gyroscope,
                                 const BagContents& contents);

}  // namespace chasles
