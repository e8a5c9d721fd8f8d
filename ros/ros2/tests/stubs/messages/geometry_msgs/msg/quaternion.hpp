#pragma once

namespace geometry_msgs::msg {

struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
};

}  // namespace geometry_msgs::msg
