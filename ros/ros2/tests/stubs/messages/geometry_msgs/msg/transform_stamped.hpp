#pragma once

#include <string>

#include <geometry_msgs/msg/transform.hpp>
#include <std_msgs/msg/header.hpp>

namespace geometry_msgs::msg {

struct TransformStamped {
  std_msgs::msg::Header header;
  std::string child_frame_id;
  Transform transform;
};

}  // namespace geometry_msgs::msg
