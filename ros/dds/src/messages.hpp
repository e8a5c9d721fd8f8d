#pragma once

#include <dds/dds.h>

#include "ros2_messages.h"

namespace chasles::bridge {

/// The type of a topic: the structure that idlc made of its IDL, and the description of it.
template <typename Message>
struct TopicType;

#define CHASLES_TOPIC_TYPE(NAME, MESSAGE)                                        \
  using NAME = MESSAGE;                                                          \
  template <>                                                                    \
  struct TopicType<NAME> {                                                       \
    static const dds_topic_descriptor_t& descriptor() { return MESSAGE##_desc; } \
  }

CHASLES_TOPIC_TYPE(ImuMessage, sensor_msgs_msg_dds__Imu_);
CHASLES_TOPIC_TYPE(ImageMessage, sensor_msgs_msg_dds__Image_);
CHASLES_TOPIC_TYPE(CompressedImageMessage, sensor_msgs_msg_dds__CompressedImage_);
CHASLES_TOPIC_TYPE(OdometryMessage, nav_msgs_msg_dds__Odometry_);
CHASLES_TOPIC_TYPE(TransformsMessage, tf2_msgs_msg_dds__TFMessage_);
CHASLES_TOPIC_TYPE(PointsMessage, sensor_msgs_msg_dds__PointCloud2_);
CHASLES_TOPIC_TYPE(VehicleOdometryMessage, px4_msgs_msg_dds__VehicleOdometry_);
CHASLES_TOPIC_TYPE(DiagnosticsMessage, diagnostic_msgs_msg_dds__DiagnosticArray_);

#undef CHASLES_TOPIC_TYPE

}  // namespace chasles::bridge
