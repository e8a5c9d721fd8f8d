#pragma once

#include <geometry_msgs/msg/vector3.hpp>

namespace geometry_msgs::msg {

struct Twist {
  Vector3 linear, angular;
};

}  // namespace geometry_msgs::msg
