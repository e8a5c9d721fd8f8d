#pragma once

#include <vector>

#include <geometry_msgs/msg/transform_stamped.hpp>

namespace tf2_msgs::msg {

struct TFMessage {
  std::vector<geometry_msgs::msg::TransformStamped> transforms;
};

}  // namespace tf2_msgs::msg
