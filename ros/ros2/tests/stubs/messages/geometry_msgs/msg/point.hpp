#pragma once

namespace geometry_msgs::msg {

struct Point {
  double x = 0, y = 0, z = 0;
};

}  // namespace geometry_msgs::msg
