#pragma once

#include <geometry_msgs/msg/quaternion.hpp>
#include <geometry_msgs/msg/vector3.hpp>

namespace geometry_msgs::msg {

struct Transform {
  Vector3 translation;
  Quaternion rotation;
};

}  // namespace geometry_msgs::msg
