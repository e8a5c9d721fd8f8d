#pragma once

#include <geometry_msgs/msg/point.hpp>
#include <geometry_msgs/msg/quaternion.hpp>

namespace geometry_msgs::msg {

struct Pose {
  Point position;
  Quaternion orientation;
};

}  // namespace geometry_msgs::msg
